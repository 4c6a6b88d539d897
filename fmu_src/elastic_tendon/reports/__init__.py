"""Results for people: tables, figures, and pages; nothing is computed here.

In come results of the rooms below; out go tables for the terminal, matplotlib figures, figures to
zoom and click (`interactive/`) and stand-alone pages (`html/`, `write`).
"""

"""The report that stands alone: one HTML file that needs no network and can be printed."""

"""Machines played by MuJoCo, which shares no law, no integrator and no author with the product.

`machines` : what each is made of; `motions` : what is done to them; `play` : runs the engine and
records; `cases` : the questions that the diagnosis is asked, and what is a right answer.
"""

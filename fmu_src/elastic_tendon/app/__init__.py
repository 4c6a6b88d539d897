"""The app: one page that walks the loop, in the user's own browser (needs the extra `app`).

`server` serves it and keeps strangers out, `shell` is the page around the steps, `steps` holds one
file for each step. What the user has chosen is a `document`; what follows from it are `results`,
computed by a `workspace` in the background.
"""

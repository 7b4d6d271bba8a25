"""Flights to look at: the live page, its replay in one file, and pictures in a notebook.

Why: everything here shows and nothing decides; whoever flies never waits for a viewer.
"""

"""Manoeuvres: each a module that draws its own points from a few numbers. Why: what a pilot names in a word is a dozen
waypoints; the planner knows only those."""

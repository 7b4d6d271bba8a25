"""Campaigns: thousands of flights over a space of vehicles, worlds, links and gains, and what they say.

Why: a controller is trusted when it has flown everything. A space (space.py) says what varies; engines.py flies its
runs wherever there are processors; archive.py keeps them; the rest reads what was kept.
"""

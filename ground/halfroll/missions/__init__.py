"""Missions: what a person asks for, from a file or the wire to checked values.

Why: what is wrong with a mission is said once, here, with its item, value and limit, before anything is planned.
"""

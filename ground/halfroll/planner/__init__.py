"""The planner: a course of waypoints to the shortest flight that the rotors can fly, and the proof that they can.

Why: pure functions of numbers, the heart of the ground station; `plan.py` is where a Plan comes from.
"""

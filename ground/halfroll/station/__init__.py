"""The ground station: downloads a mission, plans it and streams its references a hundred times a second.

Why: one loop over vehicle time, the same in lockstep and in real time.
"""

"""Results: what was flown, read from its log, compared with what was planned, and shown.

Why: the log alone is evidence; nothing here has seen the flight.
"""

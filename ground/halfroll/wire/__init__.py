"""The wire: bytes, MAVLink messages and its conversations, as the ground sees them.

Why: the only package that knows sockets, pymavlink and north-east-down.
"""

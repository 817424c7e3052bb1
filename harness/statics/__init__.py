"""Statics of loads: contacts, balance, friction, first motion, what boxes bear."""

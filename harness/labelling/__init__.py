"""Labelled sets are built, labelled by the reference simulator, and screened by a faster one."""

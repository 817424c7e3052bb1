"""Judging at scale: methods x layouts -> result rows -> the evaluation of every method."""

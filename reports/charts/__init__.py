"""Kinds of charts: functions of rows and of the names of the fields that are shown."""

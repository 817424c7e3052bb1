"""Tests of properties of methods and engines, over processes."""

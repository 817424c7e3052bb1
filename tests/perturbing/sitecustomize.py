"""Interpreters that tests start under ``--perturb`` import this first."""

import os

import moved_starts

if os.environ.get(moved_starts.VARIABLE):
    moved_starts.install()

"""Loading step by step: sessions, and recordings of a judgement."""

from steadyload.methods.session.session import LoadingSession

__all__ = ["LoadingSession"]

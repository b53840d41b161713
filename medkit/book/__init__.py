"""Notebooks to a linked HTML book, and the table of what was reproduced."""

from medkit.book.replay import Replay, replay, replay_missing, replay_statement

__all__ = ["Replay", "replay", "replay_missing", "replay_statement"]

"""Notebooks to a linked HTML book, and the table of what was reproduced."""

from medkit.book.replay import Replay, replay, replay_missing, replay_statement, replay_table

__all__ = ["Replay", "replay", "replay_missing", "replay_statement", "replay_table"]

"""``python -m medkit`` is the same as the ``medkit`` command."""

from medkit.cli import main

raise SystemExit(main())

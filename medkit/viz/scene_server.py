"""``python -m medkit.viz.scene_server``: a meshcat server that ends with whoever started it.

meshcat's own server outlives a kernel that is killed. This one watches its standard input: when the
process at the other end closes it, or dies however it dies, the server ends.
"""

from __future__ import annotations

import os
import sys
import threading
from typing import Any

import tornado.web
from meshcat.servers import zmqserver


class _ThisMachineOnly(tornado.web.Application):
    """Pages for this machine; meshcat's own listens to the whole network."""

    def listen(self, port: int, address: str | None = "127.0.0.1", **options: Any) -> Any:
        return super().listen(port, address, **options)


class _Bridge(zmqserver.ZMQWebSocketBridge):  # type: ignore[misc]
    def make_app(self) -> tornado.web.Application:
        files = {"path": zmqserver.VIEWER_ROOT, "default_filename": zmqserver.VIEWER_HTML}
        return _ThisMachineOnly(
            [
                (r"/static/(.*)", zmqserver.StaticFileHandlerNoCache, files),
                (r"/", zmqserver.WebSocketHandler, {"bridge": self}),
            ]
        )


def main() -> int:
    """Serve until standard input closes; the first two lines name the addresses."""
    threading.Thread(target=_end_with_the_parent, daemon=True).start()
    bridge = _Bridge()  # takes the first free ports
    sys.stdout.write(f"{bridge.zmq_url}\n{bridge.web_url}\n")
    sys.stdout.flush()
    bridge.run()
    return 0


def _end_with_the_parent() -> None:
    sys.stdin.buffer.read()
    os._exit(0)


if __name__ == "__main__":
    raise SystemExit(main())

"""Serves a site on this machine alone."""

import logging
from collections import OrderedDict
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock
from typing import Any

from frontage.errors import FrontageError, InputError
from frontage.viewer.site import Site, SiteFile

HOST = "127.0.0.1"
_KEPT_BYTES = 256 << 20  # of files that were made
_LOG = logging.getLogger(__name__)


class SiteServer(ThreadingHTTPServer):
    """A server for one site: it listens on the loopback address, and knows the paths of the site alone."""

    daemon_threads = True

    def __init__(self, site: Site, port: int = 0) -> None:
        """Listen on `port`, 0 = any that is free. Raises InputError if it is taken."""
        self.site = site
        self._kept: OrderedDict[str, bytes] = OrderedDict()
        self._lock = Lock()
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            raise InputError(f"port {port} cannot be used ({error.strerror}); give another --port") from None

    @property
    def address(self) -> str:
        """The address to open in a browser."""
        return f"http://{HOST}:{self.server_port}/"

    @property
    def names(self) -> frozenset[str]:
        """The names under which a browser may ask; another one is a foreign page that was led here."""
        return frozenset(f"{name}:{self.server_port}" for name in (HOST, "localhost"))

    def bytes_of(self, path: str, file: SiteFile) -> bytes:
        """Return the bytes of a file; the ones asked for last are kept."""
        with self._lock:
            if path in self._kept:
                self._kept.move_to_end(path)
                return self._kept[path]
        data = file.read()
        with self._lock:
            self._kept[path] = data
            while len(self._kept) > 1 and sum(map(len, self._kept.values())) > _KEPT_BYTES:
                self._kept.popitem(last=False)
        return data


class _Handler(BaseHTTPRequestHandler):
    server: SiteServer
    server_version, sys_version = "Frontage", ""
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        self._answer(body=True)

    def do_HEAD(self) -> None:
        self._answer(body=False)

    def _answer(self, body: bool) -> None:
        if self.headers.get("Host", "") not in self.server.names:
            self._send(
                403, "text/plain; charset=utf-8", b"This viewer answers on this machine alone.\n", body
            )
            return
        file = self.server.site.find(self.path)
        if file is None:
            self._send(404, "text/plain; charset=utf-8", b"The run has no such file.\n", body)
            return
        try:
            data = self.server.bytes_of(self.path, file)
        except FrontageError as error:
            self._send(404, "text/plain; charset=utf-8", f"{error}\n".encode(), body)
            return
        self._send(200, file.media, data, body)

    def _send(self, status: int, media: str, data: bytes, body: bool) -> None:
        self.send_response(status)
        self.send_header("Content-Type", media)
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Cache-Control", "no-cache")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()
        if body:
            self.wfile.write(data)

    def log_message(self, format: str, *args: Any) -> None:
        """Log requests only where -v asks for it."""
        _LOG.info(format, *args)

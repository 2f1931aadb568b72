"""HTTP with kept connections. Standard library only; any thread."""
from __future__ import annotations

import http.client
import json
import select
import socket
import ssl
import threading
import urllib.parse
from collections.abc import Mapping
from typing import Any, cast

from .errors import ProtocolError, TimedOut, Unreachable, refusal

_MAX_IDLE = 8
# A picture may have 256 MiB before it is encoded, a set of them too.
_MAX_BODY = 512 << 20


class Answer:
    """Status below 400, headers and body."""

    def __init__(self, status: int, headers: Mapping[str, str],
                 body: bytes) -> None:
        self.status, self.headers, self.body = status, headers, body

    def json(self) -> Any:
        try:
            return json.loads(self.body)
        except (ValueError, RecursionError) as error:
            raise ProtocolError(f"no JSON in the answer: {error}") from None


class Transport:
    """One server. timeout: of each wait on the connection [s]; context: of
    TLS, none: the system's certificates."""

    def __init__(self, url: str, timeout: float,
                 headers: Mapping[str, str] | None = None,
                 context: ssl.SSLContext | None = None) -> None:
        parts = urllib.parse.urlsplit(url if "://" in url else "http://" + url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"{url!r} is not http://HOST:PORT")
        self.url = f"{parts.scheme}://{parts.netloc}{parts.path.rstrip('/')}"
        self.timeout = timeout
        self._secure = parts.scheme == "https"
        self._host, self._port = parts.hostname, parts.port
        self._prefix = parts.path.rstrip("/")
        self._headers = dict(headers or {})
        self._context = context
        self._idle: list[http.client.HTTPConnection] = []
        self._lock = threading.Lock()  # of _idle

    def connect(self, timeout: float | None = None
                ) -> http.client.HTTPConnection:
        """A new connection, open."""
        timeout = self.timeout if timeout is None else timeout
        connection: http.client.HTTPConnection
        if self._secure:
            connection = http.client.HTTPSConnection(
                self._host, self._port, timeout=timeout,
                context=self._context or ssl.create_default_context())
        else:
            connection = http.client.HTTPConnection(self._host, self._port,
                                                    timeout=timeout)
        try:
            connection.connect()
        except TimeoutError:
            raise TimedOut(f"no connection to {self.url} within "
                           f"{timeout:g} s") from None
        except ssl.SSLCertVerificationError as error:
            raise Unreachable(f"the certificate of {self.url} is not trusted "
                              f"({error.verify_message}): if it is your own, "
                              f"give it as cafile=\"cert.pem\"") from None
        except OSError as error:
            raise Unreachable(f"pelagosd does not answer at {self.url}: "
                              f"{error.strerror or error}") from None
        # Without it a request in two parts may wait 40 ms for an ACK.
        connection.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection

    def send(self, connection: http.client.HTTPConnection, method: str,
             path: str, body: bytes | None = None,
             headers: Mapping[str, str] | None = None) -> None:
        connection.request(method, self._prefix + path, body,
                           {**self._headers, **(headers or {})})

    def request(self, method: str, path: str, content: Any = None,
                headers: Mapping[str, str] | None = None,
                repeatable: bool = True) -> Answer:
        """One request; content is sent as JSON. Raises Refused for an answer
        of 400 and above. repeatable: may be sent again where a kept
        connection turns out to be closed."""
        headers = dict(headers or {})
        body = None
        if content is not None:
            body = json.dumps(content, allow_nan=False,
                              separators=(",", ":")).encode()
            headers.setdefault("Content-Type", "application/json")
        while True:
            connection, used = self._take()
            try:
                self.send(connection, method, path, body, headers)
                response = connection.getresponse()
                data = response.read(_MAX_BODY + 1)
            except TimeoutError:
                connection.close()
                raise TimedOut(f"{self.url} did not answer {method} {path} "
                               f"within {self.timeout:g} s") from None
            except (OSError, http.client.HTTPException) as error:
                connection.close()
                if used and repeatable:
                    continue
                if isinstance(error, (OSError, http.client.RemoteDisconnected,
                                      http.client.IncompleteRead)):
                    raise Unreachable(f"the connection to {self.url} broke: "
                                      f"{error}") from None
                raise ProtocolError(f"{self.url} does not speak HTTP: "
                                    f"{error!r}") from None
            except BaseException:
                connection.close()
                raise
            if len(data) > _MAX_BODY:
                connection.close()
                raise ProtocolError("the answer has no end")
            self._give(connection, response.will_close)
            if response.status >= 400:
                raise refusal(response.status, data)
            return Answer(response.status,
                          cast("Mapping[str, str]", response.headers), data)

    def _take(self) -> tuple[http.client.HTTPConnection, bool]:
        while True:
            with self._lock:
                if not self._idle:
                    break
                connection = self._idle.pop()
            # An idle connection has nothing to read, unless it was closed.
            if (connection.sock is not None
                    and not select.select([connection.sock], [], [], 0)[0]):
                return connection, True
            connection.close()
        return self.connect(), False

    def _give(self, connection: http.client.HTTPConnection,
              over: bool) -> None:
        with self._lock:
            if not over and len(self._idle) < _MAX_IDLE:
                self._idle.append(connection)
                return
        connection.close()

    def close(self) -> None:
        with self._lock:
            idle, self._idle = self._idle, []
        for connection in idle:
            connection.close()

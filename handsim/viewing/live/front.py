"""The address that browsers open: it passes everything on to the page's server, and reads links.

The server of the page does not tell what stands after ``?`` in the address by which it was opened.
So browsers connect to this address, which notes that, and passes all bytes on in both directions.
"""

import asyncio
import errno
import socket
import threading
from collections import deque

from handsim.errors import InputError

_CHUNK = 1 << 16
_TAKEN = (errno.EADDRINUSE,)
N_PORTS = 100
"""Ports that are tried, one after the other, where the first is taken."""


class Front:
    """Listens at an address, in a thread of its own, and passes connections on.

    Parameters
    ----------
    host, port
        The address. If the port is taken, the next free one is used.
    behind
        Port of the page's server on this machine.

    Attributes
    ----------
    port
        The port that was free.
    asked
        What stood after ``?`` in the addresses that were opened, oldest first.

    Raises
    ------
    InputError
        If this machine has no such address, or no port is free.
    """

    def __init__(self, host: str, port: int, behind: int) -> None:
        self.host, self._behind = host, behind
        self.asked: deque[str] = deque()
        listening = _listening(host, port)
        self.port = int(listening.getsockname()[1])
        self._open: set[asyncio.StreamWriter] = set()
        self._loop = asyncio.new_event_loop()
        starting = asyncio.start_server(self._pass_on, sock=listening)
        self._server = self._loop.run_until_complete(starting)
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening, and end all connections."""
        ended = asyncio.run_coroutine_threadsafe(self._end(), self._loop)
        ended.result(5.0)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(5.0)
        self._loop.close()

    async def _end(self) -> None:
        self._server.close()
        for writer in tuple(self._open):
            writer.transport.abort()
        # Those that wait for a connection find it closed, and end by themselves.
        await asyncio.gather(*(asyncio.all_tasks() - {asyncio.current_task()}))

    async def _pass_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Note what is asked for, and pass on all that is said.

        The page's server closes a connection with its answer, so that nothing more is asked on it.
        """
        self._open.add(writer)
        try:
            first = await reader.readuntil(b"\r\n")
            query = asked_for(first)
            if query:
                self.asked.append(query)
            there, sink = await asyncio.open_connection("127.0.0.1", self._behind)
        except (OSError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            writer.close()
            self._open.discard(writer)
            return
        both = {writer, sink}
        self._open |= both
        sink.write(first)
        await asyncio.gather(_pour(reader, sink), _pour(there, writer))
        self._open -= both


def asked_for(line: bytes) -> str:
    """Return what stands after ``?`` in the first line of a request for the page; '' if nothing."""
    method, _, rest = line.decode("latin-1").partition(" ")
    path, _, query = rest.rpartition(" ")[0].partition("?")
    return query if method == "GET" and path == "/" else ""


async def _pour(source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
    """Pass everything on until one end closes."""
    try:
        while chunk := await source.read(_CHUNK):
            sink.write(chunk)
            await sink.drain()
    except OSError:
        pass  # the one end or the other has gone
    finally:
        sink.close()


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for each in range(port, min(port + N_PORTS, 65536)):
        listening = socket.socket(family)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((host, each))
        except PermissionError as error:
            listening.close()
            raise InputError(f"port {each} may not be used; give one of 1024 on") from error
        except OSError as error:
            listening.close()
            if error.errno not in _TAKEN:
                raise InputError(f"'{host}' is no address of this machine: {error}") from error
            continue
        listening.setblocking(False)
        return listening
    raise InputError(f"no port of {port} to {port + N_PORTS - 1} is free; give another")

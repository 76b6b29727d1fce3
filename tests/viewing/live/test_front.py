"""The address in front of the page, with a server behind it that answers with what it was sent."""

import contextlib
import socket
import threading
from collections.abc import Iterator

import pytest

from handsim.errors import InputError
from handsim.viewing.live.front import N_PORTS, Front, asked_for


@pytest.fixture
def behind() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def echo() -> None:
            with contextlib.suppress(OSError):
                while True:
                    connection, _ = listening.accept()
                    with connection:
                        while chunk := connection.recv(1 << 16):
                            connection.sendall(chunk)

        thread = threading.Thread(target=echo, daemon=True)
        thread.start()
        yield listening
        listening.shutdown(socket.SHUT_RDWR)
    thread.join(5)


@pytest.fixture
def front(behind: socket.socket) -> Iterator[Front]:
    made = Front("127.0.0.1", 28200, behind.getsockname()[1])
    yield made
    made.close()


def said_through(front: Front, sent: bytes) -> bytes:
    """What comes back until as much has come as was sent."""
    with socket.create_connection(("127.0.0.1", front.port), 5) as connection:
        connection.sendall(sent)
        back = b""
        while len(back) < len(sent):
            back += connection.recv(1 << 16)
        return back


def test_everything_is_passed_on_and_links_are_noted(front: Front) -> None:
    request = (
        b"GET /?task=cup-drink&time=1.0 HTTP/1.1\r\nHost: here\r\n\r\n" + bytes(range(256)) * 999
    )
    assert said_through(front, request) == request
    assert said_through(front, b"GET /assets/x.js?v=1 HTTP/1.1\r\n") != b""
    assert said_through(front, b"GET / HTTP/1.1\r\n") != b""
    assert list(front.asked) == ["task=cup-drink&time=1.0"]


def test_what_is_asked_for() -> None:
    assert asked_for(b"GET /?a=1?b HTTP/1.1\r\n") == "a=1?b"
    for line in (
        b"POST /?a=1 HTTP/1.1\r\n",
        b"GET /x?a=1 HTTP/1.1\r\n",
        b"GET / HTTP/1.1\r\n",
        b"\r\n",
    ):
        assert asked_for(line) == ""


def test_a_server_that_has_gone_closes_the_connection() -> None:
    with socket.create_server(("127.0.0.1", 0)) as gone:
        port = gone.getsockname()[1]
    front = Front("127.0.0.1", 28200, port)
    try:
        with socket.create_connection(("127.0.0.1", front.port), 5) as connection:
            connection.sendall(b"GET / HTTP/1.1\r\n")
            assert connection.recv(10) == b""
    finally:
        front.close()


def test_the_next_free_port_is_taken_and_closed_again(front: Front) -> None:
    assert 28200 <= front.port < 28200 + N_PORTS
    other = Front("127.0.0.1", front.port, 1)
    assert other.port > front.port
    other.close()
    with pytest.raises(OSError):
        socket.create_connection(("127.0.0.1", other.port), 1)


def test_addresses_that_cannot_be_had() -> None:
    with pytest.raises(InputError, match=r"203\.0\.113\.7"):
        Front("203.0.113.7", 28200, 1)
    with pytest.raises(InputError, match=r"no\.such\.host"):
        Front("no.such.host.invalid", 28200, 1)

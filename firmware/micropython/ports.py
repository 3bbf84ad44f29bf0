"""The ways to a host: USB, or a TCP server; and the loop that serves them."""

import select
import socket
import sys
import time

# Errors of a socket that has nothing to read, or no room to write.
AGAIN = (11, 35, 110, 115)


class UsbPort:
    """Standard input and output, which a board has on USB."""

    def __init__(self):
        self.poll = select.poll()
        self.poll.register(sys.stdin, select.POLLIN)

    def read(self):
        """Return what has arrived."""
        data = b""
        while self.poll.poll(0) and len(data) < 256:
            data += sys.stdin.buffer.read(1)
        return data

    def write(self, data):
        """Send bytes."""
        sys.stdout.buffer.write(data)

    def is_busy(self):
        """Return whether bytes are still to be sent."""
        return False


class TcpPort:
    """A TCP server for one host at a time; a new one replaces it."""

    def __init__(self, number, address="0.0.0.0"):
        self.server = socket.socket()
        self.server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.server.bind(socket.getaddrinfo(address, number)[0][-1])
        self.server.listen(1)
        self.server.setblocking(False)
        self.host = None
        self.outbox = b""

    def read(self):
        """Take a new host, or return what has arrived."""
        try:
            host = self.server.accept()[0]
            self.drop()
            host.setblocking(False)
            self.host = host
        except OSError:
            pass
        data = b""
        try:
            # A ping takes longer than a few hundred bytes.
            while self.host is not None and len(data) < 4096:
                more = self.host.recv(512)
                if not more:
                    self.drop()
                data += more
        except OSError as error:
            if error.args[0] not in AGAIN:
                self.drop()
        return data

    def write(self, data):
        """Send bytes, and keep what does not go now."""
        if self.host is None:
            return
        self.outbox += data
        try:
            self.outbox = self.outbox[self.host.send(self.outbox) :]
        except OSError as error:
            if error.args[0] not in AGAIN:
                self.drop()

    def is_busy(self):
        """Return whether bytes are still to be sent."""
        return self.outbox != b""

    def drop(self):
        """Close the connection."""
        if self.host is not None:
            self.host.close()
        self.host = None
        self.outbox = b""


def serve(head, ports):
    """Run a device for ever."""
    # The counter of the board wraps after minutes; this clock does not.
    clock, before = 0, time.ticks_us()
    while True:
        for port in ports:
            data = port.read()
            if data:
                head.receive(data)
        busy = [port for port in ports if port.is_busy()]
        for port in busy:
            port.write(b"")
        now = time.ticks_us()
        clock, before = clock + time.ticks_diff(now, before), now
        if busy:
            continue
        data = head.advance(clock)
        if data:
            for port in ports:
                port.write(data)

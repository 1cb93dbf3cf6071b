# SPDX-License-Identifier: Apache-2.0
"""Takes the growing picture from eikon, which sends it as to the viewer tev (--tev). Needs no Blender."""
import socket
import struct
import threading

import numpy as np

CREATE_IMAGE, UPDATE_IMAGE = 4, 6  # operations of tev's protocol
MOST_BYTES = 1 << 30  # of a message; eikon's have about a megabyte


class Fields:
    """The fields of a message, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, form):
        """A tuple of little-endian numbers, by the letters of the module struct."""
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return values

    def text(self):
        end = self.data.index(b"\0", self.at)
        text = bytes(self.data[self.at:end]).decode("utf-8", "replace")
        self.at = end + 1
        return text

    def floats(self):
        return np.frombuffer(self.data, "<f4", offset=self.at)


class PictureReceiver:
    """Listens on the loopback address, and keeps the newest state of the one image that is sent there.

    `address` is what --tev takes. Once join() has returned, the picture is the last one, or `error` says in words why not."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.listener.getsockname()[1]
        self.error = ""
        self.lock = threading.Lock()  # guards channels, changes and size
        self.channels = {}  # by name: rows from the top, float32, of the whole image; 0 where nothing was sent
        self.changes = 0
        self.size = (0, 0)  # width and height
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def copy(self, seen):
        """(changes, channels): a copy of what has been sent, or None instead of the channels if no more was than `seen`."""
        with self.lock:
            if self.changes == seen:
                return seen, None
            return self.changes, {name: plane.copy() for name, plane in self.channels.items()}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.join()

    def join(self):
        """Takes what is on its way from a program that has ended."""
        if not self.thread.is_alive():
            self.listener.close()
            return
        # A connection of our own wakes the thread if the program never made one.
        try:
            socket.create_connection(self.listener.getsockname(), 1).close()
        except OSError:
            pass
        self.thread.join()
        self.listener.close()

    def _run(self):
        connection, _ = self.listener.accept()
        with connection:
            try:
                while (head := self._bytes(connection, 4)) is not None:
                    length = struct.unpack("<I", head)[0]
                    if not 5 <= length <= MOST_BYTES:
                        raise ValueError("a message of %d bytes" % length)
                    data = self._bytes(connection, length - 4)
                    if data is None:
                        raise ValueError("the connection ends within a message")
                    self._take(Fields(data))
            except (OSError, ValueError, KeyError, struct.error) as error:
                self.error = "the picture did not arrive as a whole: %s" % error

    @staticmethod
    def _bytes(connection, count):
        """So many bytes, or None at the end of the connection."""
        data = bytearray(count)
        view, have = memoryview(data), 0
        while have < count:
            got = connection.recv_into(view[have:])
            if got == 0:
                if have > 0:
                    raise ValueError("the connection ends within a message")
                return None
            have += got
        return data

    def _take(self, fields):
        operation, _ = fields.take("BB")
        fields.text()  # the image's name
        if operation == CREATE_IMAGE:
            width, height, count = fields.take("iii")
            with self.lock:
                self.size = (width, height)
                self.channels = {}
        elif operation == UPDATE_IMAGE:
            (count,) = fields.take("i")
            names = [fields.text() for _ in range(count)]
            x, y, width, height = fields.take("iiii")
            offsets, strides = fields.take("%dq" % count), fields.take("%dq" % count)
            values, pixels = fields.floats(), width * height
            with self.lock:
                for name, offset, stride in zip(names, offsets, strides):
                    part = values[offset:offset + (pixels - 1) * stride + 1:stride].reshape(height, width)
                    plane = self.channels.get(name)
                    if plane is None:
                        plane = self.channels[name] = np.zeros((self.size[1], self.size[0]), np.float32)
                    plane[y:y + height, x:x + width] = part
                self.changes += 1

"""A client of python-tuio: prints each cursor that it was told of, with its id and last place, once standard input is closed.

The package prints lines of its own; ours begin with `cursor`."""

import sys
import threading

from pythontuio import TuioClient, TuioListener

seen = {}


class Listener(TuioListener):
    def note(self, cursor):
        seen[cursor.session_id] = tuple(cursor.position)

    add_tuio_cursor = note
    update_tuio_cursor = note


client = TuioClient(("127.0.0.1", int(sys.argv[1])))
client.add_listener(Listener())
threading.Thread(target=client.start, daemon=True).start()
sys.stdin.read()
for name, (x, y) in sorted(seen.items()):
    print("cursor", name, x, y)

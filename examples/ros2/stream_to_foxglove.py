#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Shows a map in Foxglove while it is made: hybrid-replay ... --stream | stream_to_foxglove.py [--port N | -o FILE.mcap]

Open the connection "Foxglove WebSocket" ws://localhost:8765 and a 3D panel with the topic /hybrid/map. With -o, nothing
is served: the steps are written to a file in MCAP, which Foxglove opens. Serving needs python3-websockets.
"""

import argparse
import asyncio
import json
import struct
import sys

from bag_words import DAMAGE
from foxglove_scene import NAME, SCHEMA, TOPIC, Scene
from mcap_writer import McapWriter, nanoseconds

PROTOCOL = "foxglove.websocket.v1"


async def serve(port, scene):
    """Every viewer gets all updates so far and then each new one. A viewer subscribes to channel 1 under a number of its own."""
    import websockets
    past, news = [], asyncio.Condition()

    async def send(socket, number):
        sent = 0
        while True:
            async with news:
                await news.wait_for(lambda: len(past) > sent)
            for seconds, update in past[sent:]:
                await socket.send(struct.pack("<BIQ", 1, number, nanoseconds(seconds)) + json.dumps(update).encode())
                sent += 1

    async def meet(socket, *_):
        channel = {"id": 1, "topic": TOPIC, "encoding": "json", "schemaName": NAME, "schema": json.dumps(SCHEMA),
                   "schemaEncoding": "jsonschema"}
        await socket.send(json.dumps({"op": "serverInfo", "name": "hybrid", "capabilities": []}))
        await socket.send(json.dumps({"op": "advertise", "channels": [channel]}))
        senders = {}
        try:
            async for message in socket:
                asked = json.loads(message) if isinstance(message, str) else {}
                for wanted in asked.get("subscriptions", []) if asked.get("op") == "subscribe" else []:
                    if wanted["channelId"] == 1:
                        senders[wanted["id"]] = asyncio.create_task(send(socket, wanted["id"]))
                for number in asked.get("subscriptionIds", []) if asked.get("op") == "unsubscribe" else []:
                    if number in senders:
                        senders.pop(number).cancel()
        finally:
            for task in senders.values():
                task.cancel()

    async with websockets.serve(meet, "localhost", port, subprotocols=[PROTOCOL]) as server:
        print(f"serving ws://localhost:{server.sockets[0].getsockname()[1]}", flush=True)
        loop = asyncio.get_running_loop()
        while line := await loop.run_in_executor(None, sys.stdin.readline):
            async with news:
                past.append(scene.of_line(line))
                news.notify_all()
        print("the stream has ended; Ctrl-C stops serving", flush=True)
        await asyncio.Future()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", type=int, default=8765, help="to serve at; 0: any")
    parser.add_argument("-o", "--output", metavar="FILE.mcap", help="write a file instead of serving")
    options = parser.parse_args()
    try:
        if not options.output:
            asyncio.run(serve(options.port, Scene()))
        with open(options.output, "wb") as file, McapWriter(file, TOPIC, NAME, SCHEMA) as writer:
            scene = Scene()
            for line in sys.stdin:
                writer.write(*scene.of_line(line))
        print(f"wrote {options.output}: {writer.count} steps")
    except KeyboardInterrupt:
        pass
    except ImportError:
        sys.exit("error: serving needs python3-websockets; -o FILE.mcap writes a file instead")
    except OSError as error:
        sys.exit(f"error: cannot {f'write {options.output}' if options.output else 'serve'}: {error.strerror}")
    except DAMAGE as error:
        sys.exit(f"error: {error}: standard input is what hybrid-replay --stream writes")


if __name__ == "__main__":
    main()

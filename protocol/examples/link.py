"""The connection of a host: sends messages, checks that each is answered, unpacks frames, measures delays."""

import json
import threading
import time

from frames import unpack
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

# A first picture may have to wait for tables that are built once.
PATIENCE_S = 60.0


class Wrong(Exception):
    """The server did something that the protocol does not allow, or refused a message."""


def percentile(values, share):
    """The smallest value that is no less than `share` of all (nearest rank); 0 when there are none."""
    return sorted(values)[max(0, -int(-share * len(values) // 1) - 1)] if values else 0.0


class Link:
    """One host's connection. Use it as a context manager; `tell` and `ask` send, a thread receives."""

    def __init__(self, address, token=None, folder=None, every=0):
        headers = {"Authorization": f"Bearer {token}"} if token else None
        self._socket = connect(address, additional_headers=headers, max_size=None, compression=None)
        self._folder, self._every = folder, every
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
        # Guards everything below, and tells when something has arrived.
        self._news = threading.Condition()
        self._seq = 0
        self._waiting = {}
        self._answers = {}
        self._sent_at = {}
        self._host_frames = None
        self._newest = {}
        self._failure = None
        self._closing = False
        self._frames, self._dropped, self._strikes, self._delays_ms = 0, 0, 0, []
        self._first_frame_at = self._last_frame_at = None
        self._receiver = threading.Thread(target=self._receive, daemon=True)
        self._receiver.start()
        hello = {"type": "hello", "protocol": "stormdeck.v1", "role": "host", "name": "python host"}
        if token:
            hello["token"] = token
        self.welcome = self.ask(hello)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._closing = True
        self._socket.close()

    def tell(self, message, keep_answer=False):
        """Sends a message; its answer is checked when it comes. Returns the message's number."""
        with self._news:
            self._raise_failure()
            self._seq += 1
            seq = self._seq
            self._waiting[seq] = message["type"]
            if keep_answer:
                self._answers[seq] = None
            if message["type"] == "ownship":
                number = message["host_frame"]
                self._sent_at[number] = time.monotonic()
                self._host_frames = (self._host_frames[0] if self._host_frames else number, number)
        try:
            self._socket.send(json.dumps({**message, "seq": seq}))
        except ConnectionClosed as closed:
            raise Wrong(f"the server closed the connection: {closed}") from closed
        return seq

    def ask(self, message):
        """Sends a message and waits for its answer."""
        seq = self.tell(message, keep_answer=True)
        with self._news:
            if not self._news.wait_for(lambda: self._failure or self._answers[seq], PATIENCE_S):
                raise Wrong(f"{message['type']} was not answered for {PATIENCE_S:.0f} s")
            self._raise_failure()
            return self._answers.pop(seq)

    def simulation_time_s(self):
        """The server's simulation time now."""
        return self.ask({"type": "query", "what": "state"})["simulation_time_s"]

    def wait_until(self, moment):
        """Sleeps until a moment of `time.monotonic`."""
        left = moment - time.monotonic()
        if left > 0:
            time.sleep(left)

    def wait_for_frame(self, host_frame):
        """Waits for a frame that shows an ownship message; its delay is not counted."""
        with self._news:
            shown = lambda: self._failure or any(frame.host_frame >= host_frame for frame in self._newest.values())
            if not self._news.wait_for(shown, PATIENCE_S):
                raise Wrong(f"no picture came for {PATIENCE_S:.0f} s")
            self._raise_failure()
            self._delays_ms.clear()

    def finish(self):
        """Waits until every message is answered and at least one frame is here."""
        with self._news:
            done = lambda: self._failure or (not self._waiting and self._frames)
            if not self._news.wait_for(done, PATIENCE_S):
                missing = sorted(set(self._waiting.values()))
                raise Wrong(f"{len(self._waiting)} messages ({', '.join(missing)}) were not answered; {self._frames} frames came")
            self._raise_failure()

    def summary(self):
        """Frames a second, delay from message to frame, and what was lost."""
        with self._news:
            span_s = (self._last_frame_at or 0.0) - (self._first_frame_at or 0.0)
            rate = (self._frames - 1) / span_s if span_s > 0 else 0.0
            delays = self._delays_ms
            return (
                f"{self._frames} frames, {rate:.1f} a second, {self._dropped} dropped, {self._strikes} strikes shown; "
                f"message to frame: median {percentile(delays, 0.5):.1f} ms, p99 {percentile(delays, 0.99):.1f} ms"
            )

    def _raise_failure(self):
        if self._failure:
            raise Wrong(self._failure)

    def _receive(self):
        try:
            for message in self._socket:
                now = time.monotonic()
                with self._news:
                    if isinstance(message, str):
                        self._control(json.loads(message))
                    else:
                        self._frame(unpack(message), now)
                    self._news.notify_all()
            reason = "the server closed the connection"
        except (ConnectionClosed, ValueError, OSError) as error:
            reason = f"{type(error).__name__}: {error}"
        except Wrong as wrong:
            reason = str(wrong)
        with self._news:
            if not self._closing:
                self._failure = self._failure or reason
            self._news.notify_all()

    def _control(self, message):
        kind, seq = message["type"], message.get("seq")
        if kind == "refused":
            what = self._waiting.pop(seq, "a message")
            raise Wrong(f"{what} was refused: {message['field']} = {message['value']}: {message['why']} (limit: {message['limit']})")
        if kind == "event" and message["event"] == "fault":
            raise Wrong(f"the server had a fault: {message['what']}")
        if kind == "event" and message["event"] == "strike_shown":
            self._strikes += 1
        if seq is not None:
            if self._waiting.pop(seq, None) is None:
                raise Wrong(f"{kind} answers message {seq}, which nothing waits for")
            if seq in self._answers:
                self._answers[seq] = message

    def _frame(self, frame, now):
        first, newest = self._host_frames or (0, -1)
        if not first <= frame.host_frame <= newest:
            # Drawn for somebody before us; afterwards such a frame would be wrong.
            if frame.view in self._newest:
                raise Wrong(f"{frame.view}: host frame {frame.host_frame} was never sent")
            return
        before = self._newest.get(frame.view)
        if before is not None and (frame.number <= before.number or frame.host_frame < before.host_frame):
            raise Wrong(
                f"{frame.view}: frame {frame.number} of host frame {frame.host_frame} follows {before.number} of {before.host_frame}"
            )
        self._newest[frame.view] = frame
        self._dropped = frame.dropped
        self._first_frame_at = self._first_frame_at or now
        self._last_frame_at = now
        sent_at = self._sent_at.get(frame.host_frame)
        if sent_at is not None:
            self._delays_ms.append(1000.0 * (now - sent_at))
            # The first frame that shows a message counts.
            self._sent_at = {number: at for number, at in self._sent_at.items() if number > frame.host_frame}
        if self._folder is not None and self._frames % self._every == 0:
            name = f"{frame.view}-{frame.simulation_time_s:07.2f}s-{frame.number:06d}.{frame.format}"
            (self._folder / name).write_bytes(frame.picture)
        self._frames += 1

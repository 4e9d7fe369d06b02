"""A building as a BACnet device, driven by BAC0, a third-party client."""

import asyncio
import inspect
import socket
import struct
import subprocess
import sys
import time
import warnings
from contextlib import closing, contextmanager

import building2building as b2b
import numpy as np
import pytest

BAC0 = pytest.importorskip("BAC0")
pytest.importorskip("bacpypes3")

STEPS = 24


def free_port():
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def served(steps: int, period="01-09..01-09", speed="0"):
    address = f"127.0.0.1:{free_port()}"
    command = ["-m", "building2building.bacnet", "OfficeSmall", "--period", period, "--speed", speed]
    command += ["--address", address.replace(":", "/24:")]
    process = subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, text=True)
    assert f"{steps} steps" in process.stdout.readline()
    yield address
    assert process.poll() is None, "the server is running"
    process.terminate()
    process.wait()


@pytest.fixture
def plant():
    with served(288) as address:
        yield address


def as_client(session):
    async def run():
        async with BAC0.start(ip="127.0.0.1/24", port=free_port()) as client:
            return await session(client)

    return asyncio.run(run())


def test_a_client_reads_points_runs_steps_and_commands_actuators(plant):
    env = b2b.make_env("OfficeSmall", run_period="01-09..01-09")
    own = b2b.rollout(env, b2b.Guideline36Controller(env), steps=STEPS)
    names, actuator = env.metadata["observation_names"], env.layout.action[0]

    async def session(client):
        async def read(point, name="presentValue"):
            return await client.read(f"{plant} {point} {name}")

        assert await read("analogInput 1", "objectName") == names[0]
        assert str(await read("analogInput 1", "units")) == "degrees-celsius"
        assert await read("analogOutput 1", "maxPresValue") == pytest.approx(actuator.high, rel=1e-6)

        # Without commands, the plant follows the baseline.
        await client._write(f"{plant} analogValue 1 presentValue {STEPS}")
        assert await read("analogValue 2") == 288 - STEPS
        assert await read("analogValue 4") == pytest.approx(own.episode_return, rel=1e-6)
        temperature = await read("analogInput 1")
        assert temperature == pytest.approx(own.observed(names[0])[-1], rel=1e-6)

        # A command holds an actuator until it is relinquished.
        await client._write(f"{plant} analogOutput 1 presentValue {actuator.high} - 8")
        await client._write(f"{plant} analogValue 1 presentValue 2")
        assert await read("analogOutput 1") == pytest.approx(actuator.high, rel=1e-6)
        await client._write(f"{plant} analogOutput 1 presentValue null - 8")
        assert await read("analogOutput 1") < actuator.high

        await client._write(f"{plant} binaryValue 1 presentValue active")
        assert await read("analogValue 2") == 288
        return True

    assert as_client(session)


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["OficeSmall"], "OfficeSmall"),
        (["OfficeSmall", "--task", "cosy"], "cosy"),
        (["OfficeSmall", "--speed", "-1"], "speed is -1"),
        (["OfficeSmall", "--place", "Dever"], "Denver"),
        (["OfficeSmall", "--weather", "nowhere.epw"], "nowhere.epw"),
    ],
)
def test_an_invalid_argument_of_the_command_is_a_message(arguments, words, monkeypatch, capsys):
    from building2building import bacnet

    monkeypatch.setattr(sys, "argv", ["bacnet", *arguments])
    with pytest.raises(SystemExit) as ended:
        bacnet.main()
    assert ended.value.code == 2 and words in capsys.readouterr().err


def test_a_speed_that_is_not_positive_is_refused():
    from building2building.bacnet import serve

    env = b2b.make_env("OfficeSmall", run_period="01-09..01-09", task="constant")
    with pytest.raises(b2b.errors.SettingError, match="speed is -1"):
        asyncio.run(serve(env, speed=-1))


#: BACnet's numbers of object types, properties and errors.
INPUT, OUTPUT, VALUE, DEVICE = 0, 1, 2, 8
PRESENT, MAXIMUM, MINIMUM, NAME, OUT_OF_SERVICE, RELINQUISH_DEFAULT = 85, 65, 69, 77, 81, 104
OUT_OF_RANGE, WRITE_DENIED = 37, 40


def real(value: float) -> bytes:
    return b"\x44" + struct.pack(">f", value)


class Client:
    """A client that sends raw datagrams."""

    def __init__(self, address: str):
        host, port = address.split(":")
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect((host, int(port)))
        self.invoke = 0
        # The server opens its socket after its first line.
        deadline = time.monotonic() + 60
        while self.ready() is None:
            assert time.monotonic() < deadline, "the server does not answer"

    def ready(self) -> bytes | None:
        try:
            self.socket.send(self.request(0x0C, VALUE, 2, PRESENT))
            return self.answer(1)
        except ConnectionRefusedError:
            time.sleep(0.1)
            return None

    def request(self, service: int, kind: int, number: int, name: int, rest=b"") -> bytes:
        self.invoke += 1
        reference = b"\x0c" + struct.pack(">I", kind << 22 | number) + bytes([0x19, name])
        apdu = bytes([0x00, 0x05, self.invoke, service]) + reference + rest
        return struct.pack(">BBHBB", 0x81, 0x0A, len(apdu) + 6, 1, 4) + apdu

    def write_request(self, kind: int, number: int, value: bytes, name: int = PRESENT, priority=None) -> bytes:
        rest = b"\x3e" + value + b"\x3f" + (b"" if priority is None else bytes([0x49, priority]))
        return self.request(0x0F, kind, number, name, rest)

    def answer(self, timeout: float) -> bytes | None:
        self.socket.settimeout(timeout)
        try:
            return self.socket.recv(1500)[6:]
        except TimeoutError:
            return None

    def write(self, *arguments, **options) -> int | None:
        """Writes a value and returns the code of the error, if there is one."""
        self.socket.send(self.write_request(*arguments, **options))
        answer = self.answer(60)
        if answer[0] == 0x20:
            return None
        assert answer[0] == 0x50 and answer[3] == answer[5] == 0x91, answer.hex()
        return answer[6]

    def read(self, kind: int, number: int) -> float:
        self.socket.send(self.request(0x0C, kind, number, PRESENT))
        answer = self.answer(60)
        return struct.unpack(">f", answer[answer.index(b"\x3e\x44") + 2 :][:4])[0]


@pytest.mark.nightly
def test_steps_run_once_however_often_their_request_is_sent():
    steps = 31 * 288
    with served(steps, "01-01..01-31") as plant:
        client = Client(plant)
        many, one, two = (client.write_request(VALUE, 1, real(count)) for count in (3000, 10, 10))
        client.socket.send(many)
        # Clients repeat a request that is not answered within three seconds.
        time.sleep(3.5)
        client.socket.send(many)
        assert client.answer(120)[0] == 0x20
        while client.answer(1) is not None:
            pass
        assert client.read(VALUE, 2) == steps - 3000
        for _ in range(3):
            client.socket.send(one)
            assert client.answer(60)[0] == 0x20
        client.socket.send(two)
        assert client.answer(60)[0] == 0x20
        assert client.read(VALUE, 2) == steps - 3020


def test_values_out_of_bounds_are_refused_and_end_nothing():
    with served(288, speed="3000") as plant:
        client = Client(plant)
        for value in (float("nan"), float("inf"), -float("inf"), -1.0, 1e6):
            assert client.write(OUTPUT, 1, real(value), priority=8) == OUT_OF_RANGE
        for value in (float("nan"), -1.0, 1.5, 1e6):
            assert client.write(VALUE, 1, real(value)) == OUT_OF_RANGE
        left = client.read(VALUE, 2)
        time.sleep(1)
        assert client.read(VALUE, 2) < left


@pytest.mark.nightly
def test_nothing_but_outputs_and_requests_can_be_written(plant):
    client = Client(plant)
    before = [client.read(*each) for each in ((INPUT, 1), (VALUE, 2), (VALUE, 3), (VALUE, 4), (OUTPUT, 1))]
    false, text = b"\x10", b"\x75\x02\x00x"
    for write in (
        (INPUT, 1, real(21.0)),
        (VALUE, 2, real(5.0)),
        (VALUE, 3, real(0.0)),
        (VALUE, 4, real(0.0)),
        (OUTPUT, 1, real(1e6), MAXIMUM),
        (OUTPUT, 1, real(-1e6), MINIMUM),
        (OUTPUT, 1, real(float("nan")), RELINQUISH_DEFAULT),
        (OUTPUT, 1, b"\x11", OUT_OF_SERVICE),
        (OUTPUT, 1, text, NAME),
        (VALUE, 1, text, NAME),
        (INPUT, 1, false, OUT_OF_SERVICE),
        (DEVICE, 26100, text, NAME),
    ):
        assert client.write(*write) == WRITE_DENIED, write
    after = [client.read(*each) for each in ((INPUT, 1), (VALUE, 2), (VALUE, 3), (VALUE, 4), (OUTPUT, 1))]
    assert after == before
    # Clients can command the bounds that they read.
    high = b2b.make_env("OfficeSmall", run_period="01-09..01-09", task="constant").layout.action[0].high
    assert client.write(OUTPUT, 1, real(high), priority=8) is None
    assert client.read(OUTPUT, 1) == np.float32(high)
    assert client.write(OUTPUT, 1, b"\x00", priority=8) is None


def test_the_default_address_is_local_and_any_other_is_a_warning(monkeypatch, capsys):
    from building2building import bacnet

    for function in (bacnet.serve, bacnet.Plant):
        assert inspect.signature(function).parameters["address"].default == "127.0.0.1/24:47808"
    monkeypatch.setattr(sys, "argv", ["bacnet", "--help"])
    with pytest.raises(SystemExit):
        bacnet.main()
    assert "127.0.0.1/24:47808, of this machine" in " ".join(capsys.readouterr().out.split())
    for address in ("0.0.0.0/24:47808", "192.168.1.10/24", "[::]:47808", "plant"):
        with pytest.warns(UserWarning, match="no authentication"):
            bacnet._warn_if_reachable(address)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bacnet._warn_if_reachable("127.0.0.1/24:47808")

"""A building as a BACnet device, driven by BAC0, a client by others."""

import asyncio
import socket
import subprocess
import sys
from contextlib import closing

import building2building as b2b
import pytest

BAC0 = pytest.importorskip("BAC0")
pytest.importorskip("bacpypes3")

STEPS = 24


def free_port():
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def plant():
    address = f"127.0.0.1:{free_port()}"
    command = ["-m", "building2building.bacnet", "OfficeSmall", "--period", "01-09..01-09", "--speed", "0"]
    command += ["--address", address.replace(":", "/24:")]
    process = subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, text=True)
    assert "288 steps" in process.stdout.readline()
    yield address
    process.terminate()
    process.wait()


def as_client(session):
    async def run():
        async with BAC0.start(ip="127.0.0.1/24", port=free_port()) as client:
            return await session(client)

    return asyncio.run(run())


def test_a_client_reads_points_runs_steps_and_commands_actuators(plant):
    env = b2b.make_env("OfficeSmall", run_period="01-09..01-09")
    own = b2b.rollout(env, b2b.ReactiveController(env), steps=STEPS)
    names, actuator = env.metadata["observation_names"], env.layout.action[0]

    async def session(client):
        async def read(point, name="presentValue"):
            return await client.read(f"{plant} {point} {name}")

        assert await read("analogInput 1", "objectName") == names[0]
        assert str(await read("analogInput 1", "units")) == "degrees-celsius"
        assert await read("analogOutput 1", "maxPresValue") == pytest.approx(actuator.high, rel=1e-6)

        # Without commands the plant is under its own control.
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

    env = b2b.make_env("OfficeSmall", run_period="01-09..01-09")
    with pytest.raises(b2b.errors.SettingError, match="speed is -1"):
        asyncio.run(serve(env, speed=-1))

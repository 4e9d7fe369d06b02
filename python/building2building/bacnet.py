"""A building as a BACnet device, for controllers and workstations that drive real plants. Needs ``bacpypes3``.

``python -m building2building.bacnet OfficeSmall`` serves one; ``--help`` lists the options.
"""

from __future__ import annotations

import argparse
import asyncio
import ipaddress
import math
import warnings
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .buildings import find_building
from .env import BuildingEnv
from .errors import Error, SettingError, need
from .registration import make_env
from .rollouts import BuiltInController

#: BACnet's names of units; any other is only in an object's description.
_UNITS = {"°C": "degreesCelsius", "%": "percentRelativeHumidity", "h": "hours", "kg/s": "kilogramsPerSecond"}
#: A vendor id that ASHRAE reserves.
_VENDOR = 999
#: Default address: only this machine can reach it.
_ADDRESS = "127.0.0.1/24:47808"
#: How long a client may take to repeat an unanswered request, s.
_RESENT = 5.0
#: How long a request may take, ms.
_LONGEST_REQUEST = 24 * 3600 * 1000
#: The status of every object.
_STATUS: dict[str, Any] = {"statusFlags": [0, 0, 0, 0], "eventState": "normal", "outOfService": False}


class Plant:
    """An environment as a BACnet device.

    =====================  ===========================================================================================
    ``analog-input i``     Slot i of the observation, from 1.
    ``analog-output i``    Actuator i, from 1, in physical units. Commandable within its bounds: without a command, and
                           after one is relinquished, it takes the action of the task's baseline, like a point under
                           a building's own control.
    ``analog-value 1``     *steps to run*: a client writes a number of steps, and gets the reply after these steps. A
                           request that the client sends again runs nothing.
    ``analog-value 2``     *steps left* in the episode.
    ``analog-value 3``     *reward* of the last step.
    ``analog-value 4``     *return* of the episode.
    ``binary-value 1``     *new episode*: begins one when ``active`` is written.
    =====================  ===========================================================================================

    Names, units and bounds are in the objects. Clients can write the present value of outputs, of *steps to run* and of
    *new episode*, and nothing else. BACnet/IP has no authentication: whoever reaches the address can do so. BACnet's
    numbers are f32; actions of the baseline keep f64.
    """

    def __init__(self, env: BuildingEnv, address: str = _ADDRESS, *, device: int = 26100) -> None:
        """Opens the device on an address of the form ``ip/bits:port``; call it in a running event loop."""
        need("bacpypes3", "bacpypes3")
        from bacpypes3.local.analog import AnalogValueObject
        from bacpypes3.local.device import DeviceObject
        from bacpypes3.local.networkport import NetworkPortObject

        _warn_if_reachable(address)
        self.env = env
        #: Held while steps run.
        self.running = asyncio.Lock()
        self._controller = BuiltInController(env, kind=env.setting.baseline)
        layout = env.layout
        self._inputs = [_input(number, slot) for number, slot in enumerate(layout.observation, 1)]
        self._outputs = [_output(number, slot) for number, slot in enumerate(layout.action, 1)]
        self._steps_to_run, self._new_episode = _requests(self)
        self._steps_left, self._reward, self._return = (
            _read_only(AnalogValueObject, **_value(*each))
            for each in (
                (2, "steps left", "steps that are left in the episode"),
                (3, "reward", "reward of the last step"),
                (4, "return", "sum of the rewards of the episode"),
            )
        )
        values = (self._steps_to_run, self._steps_left, self._reward, self._return, self._new_episode)
        self._device = _read_only(
            DeviceObject,
            objectIdentifier=("device", device),
            objectName=env.building.name,
            description=f"{env.building.name} in {env.building.place}, simulated by EnergyPlus",
            vendorIdentifier=_VENDOR,
            modelName="building2building",
        )
        port = NetworkPortObject(address, objectIdentifier=("network-port", 1), objectName="network port")
        objects = [self._device, port, *self._inputs, *self._outputs, *values]
        self._application = _application().from_object_list(objects)
        # A transaction that is given up would run again when the client sends its request again.
        self._application.asap.applicationTimeout = _LONGEST_REQUEST
        self.reset()

    def reset(self) -> None:
        """Begins an episode. Commands stay in effect."""
        self.env.reset()
        self._controller.reset()
        self._episode_return = 0.0
        self._show(0.0)

    @property
    def steps_left(self) -> int:
        """Number of steps that are left in the episode."""
        return self.env.setting.episode_steps - self.env.steps

    def step_if_left(self) -> None:
        """Advances by one step, unless the episode has ended."""
        if not self.steps_left:
            return
        _, reward, _, _, _ = self.env.step(self._action(), rescale=False)
        self._episode_return += reward
        self._show(reward)

    def close(self) -> None:
        """Closes the device; the environment stays open."""
        self._application.close()

    def _action(self) -> NDArray[np.float64]:
        """Returns the next action: commands, and the baseline's actions where there are none."""
        commanded = [output.currentCommandPriority.unsigned is not None for output in self._outputs]
        return np.where(commanded, [float(output.presentValue) for output in self._outputs], self._own)

    def _show(self, reward: float) -> None:
        """Shows the state after a step."""
        for point, value in zip(self._inputs, self.env.observation):
            point.presentValue = float(value)
        # Only once per observation, because the controllers integrate.
        self._own = self._controller.physical(self.env.observation)
        for output, value in zip(self._outputs, self._own):
            output.relinquishDefault = float(value)
            output.recalculating()
        self._steps_left.presentValue = float(self.steps_left)
        self._reward.presentValue, self._return.presentValue = float(reward), self._episode_return


def _read_only(base: Any, **properties: Any) -> Any:
    """Makes an object that clients cannot write."""
    from bacpypes3.errors import PropertyError

    class ReadOnly(base):
        async def write_property(self, *_: Any) -> None:
            raise PropertyError("writeAccessDenied")

    return ReadOnly(**properties)


def _writable(
    base: Any, check: Callable[[Any], None], written: Callable[[Any], Awaitable[None]], **properties: Any
) -> Any:
    """Makes an object whose present value clients can write, and nothing else: ``check`` raises for invalid values, and
    ``written`` is called after each write."""
    from bacpypes3.errors import PropertyError

    class Writable(base):
        async def write_property(self, attr: Any, value: Any, index: Any = None, priority: Any = None) -> None:
            name = self._property_identifier_class(attr).attr if isinstance(attr, int) else attr
            if name != "presentValue" or index is not None:
                raise PropertyError("writeAccessDenied")
            check(value)
            await super().write_property(attr, value, index, priority)
            await written(self)

    return Writable(**properties)


def _input(number: int, slot: Any) -> Any:
    """Makes the object of a slot of the observation."""
    from bacpypes3.local.analog import AnalogInputObject

    return _read_only(AnalogInputObject, **_analog("input", number, slot))


def _output(number: int, slot: Any) -> Any:
    """Makes the object of an actuator, which refuses commands out of its bounds."""
    from bacpypes3.errors import PropertyError
    from bacpypes3.local.analog import AnalogOutputObject

    # In f32, as clients read the bounds.
    low, high = float(np.float32(slot.low)), float(np.float32(slot.high))

    def check(value: Any) -> None:
        # Null relinquishes a command; NaN is out of bounds.
        if not isinstance(value, tuple) and not low <= float(value) <= high:
            raise PropertyError("valueOutOfRange")

    async def written(_: Any) -> None:
        pass

    return _writable(AnalogOutputObject, check, written, **_analog("output", number, slot))


def _analog(kind: str, number: int, slot: Any) -> dict[str, Any]:
    """Returns the properties of the object of a slot of the observation or the action."""
    unit = "" if slot.unit == "1" else f", {slot.unit}"
    return {
        "objectIdentifier": (f"analog-{kind}", number),
        "objectName": slot.name,
        "description": f"{slot.name}{unit}",
        "presentValue": float(slot.low),
        "minPresValue": float(slot.low),
        "maxPresValue": float(slot.high),
        "units": _UNITS.get(slot.unit, "noUnits"),
        **_STATUS,
        "covIncrement": 0.01,
    }


def _value(number: int, name: str, description: str) -> dict[str, Any]:
    """Returns the properties of an analog value."""
    return {
        "objectIdentifier": ("analog-value", number),
        "objectName": name,
        "description": description,
        "presentValue": 0.0,
        "units": "noUnits",
        **_STATUS,
        "covIncrement": 0.0,
    }


def _requests(plant: Plant) -> tuple[Any, Any]:
    """Makes the objects that a client writes to run steps and to begin an episode."""
    from bacpypes3.errors import PropertyError
    from bacpypes3.local.analog import AnalogValueObject
    from bacpypes3.local.binary import BinaryValueObject

    def check_count(value: Any) -> None:
        count = float(value)
        if not (math.isfinite(count) and count.is_integer() and 0 <= count <= plant.steps_left):
            raise PropertyError("valueOutOfRange")

    async def run(point: Any) -> None:
        count, point.presentValue = int(point.presentValue), 0.0
        # One request after the other.
        async with plant.running:
            for _ in range(count):
                plant.step_if_left()
                # Answers other clients between steps.
                await asyncio.sleep(0)

    async def begin(point: Any) -> None:
        if str(point.presentValue) == "active":
            point.presentValue = "inactive"
            async with plant.running:
                plant.reset()

    steps_to_run = _value(1, "steps to run", "write a number of steps to run them")
    new_episode = {
        "objectIdentifier": ("binary-value", 1),
        "objectName": "new episode",
        "description": "write active to begin an episode",
        "presentValue": "inactive",
        **_STATUS,
    }
    return (
        _writable(AnalogValueObject, check_count, run, **steps_to_run),
        _writable(BinaryValueObject, lambda _: None, begin, **new_episode),
    )


def _application() -> Any:
    """Returns the class of an application that carries out every write once, however often a client sends it.

    A client sends a request again, under the same invoke id, if the answer does not come in time. Until the request is
    answered, bacpypes3 drops such copies. A copy that crosses the answer repeats the client's last request; it is
    answered but not carried out again.
    """
    from bacpypes3.apdu import SimpleAckPDU, WritePropertyMultipleRequest, WritePropertyRequest
    from bacpypes3.app import Application

    class Once(Application):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            #: For each client whose last request was a write: the write and its time.
            self._written: dict[str, tuple[bytes, float]] = {}

        async def indication(self, apdu: Any) -> None:
            if not isinstance(apdu, (WritePropertyRequest, WritePropertyMultipleRequest)):
                self._written.pop(str(apdu.pduSource), None)
            await super().indication(apdu)

        async def do_WritePropertyRequest(self, apdu: Any) -> None:
            await self._once(apdu, super().do_WritePropertyRequest)

        async def do_WritePropertyMultipleRequest(self, apdu: Any) -> None:
            await self._once(apdu, super().do_WritePropertyMultipleRequest)

        async def _once(self, apdu: Any, carry_out: Callable[[Any], Awaitable[None]]) -> None:
            client, clock = str(apdu.pduSource), asyncio.get_running_loop()
            request = bytes([apdu.apduInvokeID]) + bytes(apdu.encode().pduData)
            last, done = self._written.pop(client, (b"", -math.inf))
            if request == last and clock.time() - done < _RESENT:
                await self.response(SimpleAckPDU(context=apdu))
            else:
                await carry_out(apdu)
            self._written[client] = request, clock.time()

    return Once


def _warn_if_reachable(address: str) -> None:
    host = address.partition("/")[0].partition(":")[0]
    try:
        local = ipaddress.ip_address(host).is_loopback
    except ValueError:
        local = False
    if not local:
        warnings.warn(
            f"{address} can be reached from other machines, and BACnet/IP has no authentication: whoever reaches it "
            "can run and command the simulation",
            stacklevel=3,
        )


def _check_speed(speed: float | None) -> None:
    if speed is not None and not 0 < speed < math.inf:
        raise SettingError(f"speed is {speed}; expected a positive number, or None")


async def serve(env: BuildingEnv, address: str = _ADDRESS, *, speed: float | None = 1.0) -> None:
    """Serves an environment as a BACnet device: see :class:`Plant`.

    ``speed`` is the number of simulated seconds per second; the call returns at the end of the episode. With ``None``
    time stands still until a client writes *steps to run*, and the call never returns.
    """
    _check_speed(speed)
    plant = Plant(env, address)
    try:
        if speed is None:
            await asyncio.Event().wait()
        else:
            clock, interval = asyncio.get_running_loop(), 3600 / env.layout.steps_per_hour / speed
            start = clock.time()
            step = 0
            while plant.steps_left:
                step += 1
                await asyncio.sleep(max(0.0, start + step * interval - clock.time()))
                async with plant.running:
                    plant.step_if_left()
    finally:
        plant.close()


def main() -> None:
    """Serves a building from the command line."""
    parser = argparse.ArgumentParser(prog="python -m building2building.bacnet", description=main.__doc__)
    parser.add_argument("building", help="building type, id (OfficeSmall-0042) or model file")
    parser.add_argument("--place", help="place, such as Miami [default: the building's]")
    parser.add_argument("--weather", help="weather file (EPW); needed for a model file")
    parser.add_argument("--task", default="operate", help="task [default: operate]")
    parser.add_argument("--period", default="winter", help="run period, such as 01-08..01-14 [default: winter]")
    parser.add_argument(
        "--address",
        default=_ADDRESS,
        help=f"ip/bits:port [default: {_ADDRESS}, of this machine alone; 0.0.0.0/24:47808 opens it to the network]",
    )
    parser.add_argument(
        "--speed",
        type=float,
        default=1.0,
        help="simulated seconds per second; 0: on request of clients [default: 1]",
    )
    arguments = parser.parse_args()
    speed = arguments.speed or None
    try:
        _check_speed(speed)
        building = find_building(arguments.building, arguments.place, arguments.weather)
        env = make_env(building=building, task=arguments.task, run_period=arguments.period)
    except Error as error:
        parser.error(str(error))
    print(f"{env.building.name} on {arguments.address}, {env.episode_steps} steps; Ctrl-C ends it", flush=True)
    try:
        asyncio.run(serve(env, arguments.address, speed=speed))
    except KeyboardInterrupt:
        pass
    finally:
        env.close()


if __name__ == "__main__":
    main()

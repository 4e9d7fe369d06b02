"""A controller that uses BOPTEST's calls, in the order of BOPTEST's own examples.

Start `b2b serve BUILDING` first; this script takes its URL and, optionally, the hours to run. The same calls work with
BOPTEST: only the URL, the test case and the names of points differ.
"""

import json
import sys
import urllib.error
import urllib.request

FLOW, TEMPERATURE = "_supply_air_flow_u", "_air_temperature_y"  # suffixes of point names
WARMER = 294.15  # K


def request(method, path, body=None):
    """Sends a request and returns the parsed answer."""
    data = None if body is None else json.dumps(body).encode()
    headers = {"Content-Type": "application/json"}
    sent = urllib.request.Request(f"{url}/{path}", data=data, headers=headers, method=method)
    try:
        with urllib.request.urlopen(sent, timeout=600) as answer:
            text = answer.read().decode()
    except urllib.error.HTTPError as error:
        sys.exit(f"{method} {path}: {error.read().decode()}")
    return text if text == "OK" else json.loads(text)


def call(method, name, body=None):
    """Sends a request of the test and returns its payload."""
    return request(method, f"{name}/{testid}", body)["payload"]


url = sys.argv[1].rstrip("/") if len(sys.argv) > 1 else "http://127.0.0.1:8000"
hours = int(sys.argv[2]) if len(sys.argv) > 2 else 48

print("version:", request("GET", "version")["payload"]["version"])
test_case = request("GET", "testcases")[0]["testcaseid"]
testid = request("POST", f"testcases/{test_case}/select")["testid"]
try:
    print("name:", call("GET", "name")["name"])
    inputs, measurements = call("GET", "inputs"), call("GET", "measurements")
    zones = [name.removesuffix(FLOW) for name in inputs if name.endswith(FLOW)]
    zones = [zone for zone in zones if zone + TEMPERATURE in measurements]

    # Seven days of warm-up, then two weeks; the answer has the measurements at their start.
    measured = call("PUT", "scenario", {"time_period": "peak_heat_day", "electricity_price": "dynamic"})["time_period"]
    print("step:", call("PUT", "step", {"step": 1800})["step"], "s")
    start = measured["time"]

    while measured and measured["time"] < start + 3600 * hours:
        ahead = call("PUT", "forecast", {"point_names": ["TDryBul"], "horizon": 21600, "interval": 3600})
        # Before it gets colder, zones that are cool get more air; otherwise the baseline controller decides.
        u = {}
        if min(ahead["TDryBul"]) < measured["outdoor_air_temperature_y"] - 1:
            for zone in zones:
                u[zone + FLOW] = inputs[zone + FLOW]["Maximum"]
                u[zone + FLOW.replace("_u", "_activate")] = int(measured[zone + TEMPERATURE] < WARMER)
        measured = call("POST", "advance", u)

    temperatures = [zone + TEMPERATURE for zone in zones]
    results = call("PUT", "results", {"point_names": temperatures, "start_time": start, "final_time": 1e9})
    print("time of the last result:", results["time"][-1] - start, "s")
    for name in temperatures:
        print(f"{name}: {min(results[name]):.2f} to {max(results[name]):.2f} K")
    for name, value in call("GET", "kpi").items():
        print(f"{name}: {value}")
finally:
    print("stop:", request("PUT", f"stop/{testid}"))

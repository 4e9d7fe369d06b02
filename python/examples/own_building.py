"""A building of your own: `python own_building.py MODEL.idf WEATHER.epw`. Without arguments, it uses a model that comes
with EnergyPlus."""

import sys

import building2building as b2b

if len(sys.argv) == 3:
    model, weather = sys.argv[1:]
else:
    model = b2b.list_engine_models()["ASHRAE901_RestaurantSitDown_STD2019_Denver"]
    weather = b2b.find_building("OfficeSmall").weather

building = b2b.import_building(model, weather)
env = b2b.make_env(building=building, run_period="01-09..01-10")
print(env.morphology)
print("actuators:", ", ".join(env.metadata["action_names"]))
trajectory = b2b.rollout(env, b2b.Guideline36Controller(env))
cost, discomfort = trajectory.metrics["cost_tot"], trajectory.metrics["tdis_tot"]
print(f"cost {100 * cost:.2f} cents/m², discomfort {discomfort:.1f} K·h per zone")
env.close()

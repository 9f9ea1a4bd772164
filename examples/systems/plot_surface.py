"""
A rule base and its surface
===========================

Two inputs, three rules: a robot drives fast where its way is free and its target ahead.
"""

# sphinx_gallery_thumbnail_number = 2
import fuzzy

go = fuzzy.Sugeno(
    inputs=[
        fuzzy.Variable("distance", (0, 2), {"near": fuzzy.LinearZ(0.2, 1), "far": fuzzy.LinearS(0.2, 1)}, unit="m"),
        fuzzy.Variable("bearing", (-3, 3), {"ahead": fuzzy.Gaussian(0.5, 0), "left": fuzzy.SShape(0, 1.5)}, unit="rad"),
    ],
    outputs=[fuzzy.Variable("v", (0, 1), {"stop": 0, "creep": 0.1, "cruise": 0.6}, unit="m/s")],
    rules=[
        "if distance is far and bearing is ahead then v is cruise",
        "if distance is near or bearing is not ahead then v is creep",
        "if bearing is very left then v is stop with 0.5",
    ],
)
memberships = fuzzy.plot_memberships(go)

# %%
# What it answers over its whole universe of discourse. With a target far to the left it is slower than with one to the
# right: there the third rule, which counts half, says stop.

figure = fuzzy.plot_surface(go)
print(f"0.5 m before it, ahead: v = {go([0.5, 0.0])[0]:.2f} m/s")
for side, bearing in (("left", 2.0), ("right", -2.0)):
    print(f"0.5 m before it, 2 rad to the {side}: v = {go([0.5, bearing])[0]:.2f} m/s")

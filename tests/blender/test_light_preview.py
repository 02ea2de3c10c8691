# SPDX-License-Identifier: GPL-3.0-or-later
"""The preview while scrubbing: called in a frame handler, with solids that are kept."""

import bpy
import pytest
from light_stage import facing, lamp, lux, material, measure, part, plate, preview, request

ASKED = (
    request("up", engine="DIRECT"),
    request("aside", matrix=facing((1, 0, 1), (0.3, 0, 0)), engine="DIRECT"),
    request("walls", method="FOUR_WALL", engine="DIRECT"),
)


@pytest.fixture
def scrub():
    """Measures in a frame handler; a list that grows by what each frame gave."""
    solids, found = part("rays.solids").Solids(), []

    @bpy.app.handlers.persistent
    def follow(_, depsgraph):
        solids.note(depsgraph, edited=False, by_frame=False)
        solids.sync(depsgraph)
        found.append(
            part("light.probe").measure_direct(solids, depsgraph, list(ASKED), efficacy=1.0)
        )

    bpy.app.handlers.frame_change_post.append(follow)
    yield found
    bpy.app.handlers.frame_change_post.remove(follow)


def glass():
    """Lets half of the light pass."""
    made = material(0.5, name="glass")
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    clear, output = nodes.new("ShaderNodeBsdfTransparent"), nodes.new("ShaderNodeOutputMaterial")
    clear.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
    links.new(clear.outputs[0], output.inputs["Surface"])
    return made


def room(world):
    box = world.box((4, 4, 4))
    box.data.materials.append(material(0.5))
    light = lamp(world, "POINT", at=(0, 0, 1.5), energy=30.0)
    shade = plate(world, 1.0, (0, 0, 1), (0, 0, -1), material(0.2))
    world.key(shade, "location", {10: (0, 0, 1), 20: (1.5, 0, 1), 30: (0, 0, 1)})
    pane = plate(world, 1.0, (0, 0, 0.5), (0, 0, -1), glass())
    world.key(pane, "location", {10: (1.5, 0, 0.5), 30: (1.5, 0, 0.5), 40: (0, 0, 0.5)})
    world.key(light, "location", {30: (0, 0, 1.5), 48: (0.5, 0, 1.7)})


def test_what_is_remembered_from_frame_to_frame_changes_no_bit(world, scrub):
    room(world)
    found = scrub
    frames = [1, 12, 20, 20, 27, 30, 36, 40, 48, 3, 20]
    for frame in frames:
        world.scene.frame_set(frame)
    assert len(found) == len(frames)
    seen = set()
    for frame, kept in zip(frames, list(found), strict=True):
        world.scene.frame_set(frame)
        assert kept == preview(*ASKED), frame
        seen.add(kept["up"].illuminance_lux)
    # Shaded, lit, and through the pane.
    assert len(seen) > 4


def by_closed_form():
    (sample,) = preview(request(engine="DIRECT")).values()
    return sample.illuminance_lux


def test_light_through_panes_is_dimmed_by_each(world):
    """A sheet has one face: half the light; two of them: a quarter."""
    lamp(world, "SUN")
    assert by_closed_form() == pytest.approx(1.0)
    for count in (1, 2):
        plate(world, 1.0, (0, 0, count), (0, 0, -1), glass())
        assert by_closed_form() == pytest.approx(0.5**count, rel=1e-6)
        assert lux(request(samples=64)) == pytest.approx(0.5**count, rel=0.01)


def test_a_mesh_of_several_materials_dims_where_its_face_does(world):
    """Also far from its own origin, where rays meet its triangles."""
    lamp(world, "SUN")
    for far in (0.0, 500.0):
        mesh = bpy.data.meshes.new("half pane")
        corners = [(x + far, y, 0) for y in (-1, 1) for x in (-1, 0, 1)]
        mesh.from_pydata(corners, [], [(0, 1, 4, 3), (1, 2, 5, 4)])
        mesh.materials.append(material(0.5, name="wall"))
        mesh.materials.append(glass())
        mesh.polygons[1].material_index = 1
        pane = world.link("pane", mesh, (-far, 0, 1))
        found = [
            lux(request(matrix=facing((0, 0, 1), (x, 0, 0)), engine="DIRECT")) for x in (-0.5, 0.5)
        ]
        assert found == pytest.approx([0.0, 0.5], abs=0.02)
        bpy.data.objects.remove(pane)


def test_under_the_open_sky_nothing_is_sent_back_to_a_face_that_looks_up(world):
    lamp(world, "SUN")
    plate(world, 50.0, (0, 0, -0.5), (0, 0, 1), material(0.8))
    assert lux(request(engine="DIRECT")) == pytest.approx(1.0, rel=1e-6)


def test_what_closed_forms_do_not_model_is_handed_over_to_cycles(world):
    lamp(world, "SUN")
    asked = request(engine="DIRECT", samples=64)
    (before,) = measure(asked).values()
    assert before.note == ""
    plate(world, 1.0, (0, 0, 1), (0, 0, -1), material(glows=3.0, name="ceiling panel"))
    (after,) = measure(asked).values()
    (path_traced,) = measure(request(samples=64)).values()
    assert after.illuminance_lux == path_traced.illuminance_lux
    assert after.illuminance_lux > preview(asked)["sensor"].illuminance_lux + 0.5
    assert "Cycles" in after.note and "ceiling panel" in after.note


def test_it_makes_no_datablock_and_calls_no_operator(world, scrub):
    room(world)
    world.scene.frame_set(2)
    before = [len(getattr(bpy.data, n)) for n in ("scenes", "objects", "meshes", "images")]
    for frame in range(3, 20):
        world.scene.frame_set(frame)
    assert before == [len(getattr(bpy.data, n)) for n in ("scenes", "objects", "meshes", "images")]

"""Writes a scene for POV-Ray 3.7: the same objects, lights and Phong terms, the cube map on a huge emissive box."""

from scene_file import IDENTITY, scale, sub
from sky_box import FACE_AXES, HALF_WIDTH

FAR = 1e5
# POV-Ray's attenuation is 2/(1 + (d/FADE)^2). With so small a FADE it is 2 FADE^2/d^2.
FADE = 1e-3
# The order of the six pigments in POV-Ray's `cubic` pattern.
CUBIC_ORDER = ("right", "up", "front", "left", "down", "back")


def vector(v):
    return "<" + ",".join(f"{c:.9g}" for c in v) + ">"


def write(out, scene, view, faces, bounces, shadows):
    background = scene.background.get("color", (0.5, 0.5, 0.5))
    ambient = scene.background.get("ambientLight", (0, 0, 0))
    out.write("#version 3.7;\n")
    out.write(f"global_settings {{ assumed_gamma 1 ambient_light rgb {vector(ambient)}")
    out.write(f" max_trace_level {bounces + 1} }}\n")
    out.write(f"background {{ color rgb {vector(background)} }}\n")
    write_camera(out, view)
    for kind, light in scene.lights:
        write_light(out, kind, light)
    if faces:
        write_sky(out, faces)
    for i, material in enumerate(scene.materials):
        write_material(out, i, material, bounces)
    casts = "" if shadows else " no_shadow"
    for kind, material, m, content in scene.objects:
        write_object(out, kind, m, content, f"texture {{ M{material} }}{casts}")


def write_camera(out, view):
    # POV-Ray shoots through pixel centres of a W wide window, a2 through W points from edge to edge of [-1, 1].
    right = scale(view.right, 2 * view.width / (view.width - 1))
    up = scale(view.up, 2 * view.height / (view.height - 1))
    out.write(
        f"camera {{ perspective location {vector(view.center)} direction {vector(view.forward)}"
        f" right {vector(right)} up {vector(up)} }}\n"
    )


def write_light(out, kind, light):
    if kind == "DirectionalLight":
        position = scale(light["direction"], -FAR)
        out.write(f"light_source {{ {vector(position)} color rgb {vector(light['color'])} parallel point_at 0 }}\n")
    else:
        color = scale(light["color"], 1.0 / (2.0 * FADE * FADE * light["falloff"]))
        fading = f"fade_distance {FADE} fade_power 2"
        out.write(f"light_source {{ {vector(light['position'])} color rgb {vector(color)} {fading} }}\n")


def write_sky(out, faces):
    out.write(f"box {{ <-1,-1,-1>*{HALF_WIDTH}, <1,1,1>*{HALF_WIDTH}\n pigment {{ cubic\n")
    for face in CUBIC_ORDER:
        axis, u, v = (scale(a, HALF_WIDTH) for a in FACE_AXES[face])
        corner = sub(sub(axis, u), v)
        rows = ",".join(vector(row)[1:-1] for row in (scale(u, 2), scale(v, 2), axis, corner))
        image = f'image_map {{ png "{faces[face]}.png" gamma 1 interpolate 2 once }}'
        out.write(f"  pigment {{ {image} matrix <{rows}> }}\n")
    out.write(" }\n finish { ambient 0 diffuse 0 emission 1 } no_shadow }\n")


def write_material(out, i, material, bounces):
    diffuse = material.get("diffuseColor", (1, 1, 1))
    specular = material.get("specularColor", (0, 0, 0))
    finish = "ambient 1 diffuse 1"
    if any(specular):
        finish += f" phong {sum(specular) / 3:.9g} phong_size {material.get('shininess', 0):.9g}"
    if bounces > 0 and sum(c * c for c in specular) > 0.1 * 0.1:
        finish += f" reflection {{ rgb {vector(specular)} }}"
    out.write(f"#declare M{i} = texture {{ pigment {{ rgb {vector(diffuse)} }} finish {{ {finish} }} }}\n")


def write_object(out, kind, m, content, tail):
    if kind == "TriangleMesh":
        return write_mesh(out, content.world_from(m), tail)
    if m != IDENTITY:
        rows = [tuple(m[r][c] for r in range(3)) for c in range(4)]
        tail += " matrix <" + ",".join(vector(row)[1:-1] for row in rows) + ">"
    if kind == "Sphere":
        out.write(f"sphere {{ {vector(content['center'])}, {content['radius']:.9g} {tail} }}\n")
    else:
        n = content["normal"]
        # POV-Ray measures the distance along the unit normal, a2 along the normal as given.
        distance = content["offset"] / sum(c * c for c in n) ** 0.5
        out.write(f"plane {{ {vector(n)}, {distance:.9g} {tail} }}\n")


def write_mesh(out, mesh, tail):
    out.write(f"mesh2 {{\nvertex_vectors {{ {len(mesh.vertices)}")
    out.writelines(f",\n<{x:.9g},{y:.9g},{z:.9g}>" for x, y, z in mesh.vertices)
    out.write(f" }}\nnormal_vectors {{ {len(mesh.normals)}")
    out.writelines(f",\n<{x:.9g},{y:.9g},{z:.9g}>" for x, y, z in mesh.normals)
    out.write(f" }}\nface_indices {{ {len(mesh.faces)}")
    out.writelines(f",\n<{i},{j},{k}>" for i, j, k in mesh.faces)
    out.write(f" }}\n{tail} }}\n")

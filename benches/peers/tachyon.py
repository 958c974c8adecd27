"""Writes a scene for Tachyon 0.99: the same objects, lights and Phong terms, the cube map on six far planes."""

import math

from scene_file import IDENTITY, Mesh, add, cross, dot, normal_by, normal_matrix, point_by, scale, sub, unit
from sky_box import FACE_AXES, HALF_WIDTH

# Tachyon picks a coarser picture the larger the texture's SCALE is; the factor moves from SCALE into the axes.
SHARP = 1e6
# Just below 1: then the object casts no shadow in Tachyon, and is shaded as opaque.
CASTS_NO_SHADOW = 0.9999


def vector(v):
    return " ".join(f"{c:.9g}" for c in v)


def mean(color):
    return sum(color) / 3.0


def write(out, scene, view, faces, bounces, shadows):
    mode = "FULL" if shadows else "MEDIUM"
    out.write(f"BEGIN_SCENE\nRESOLUTION {view.width} {view.height}\n")
    out.write(f"SHADER_MODE {mode} SHADOW_FILTER_OFF END_SHADER_MODE\n")
    write_camera(out, view, bounces)
    background = (0, 0, 0) if faces else scene.background.get("color", (0.5, 0.5, 0.5))
    out.write(f"BACKGROUND {vector(background)}\n")
    middle = middle_of(scene.objects)
    for kind, light in scene.lights:
        write_light(out, kind, light, middle)
    for face, name in faces.items():
        write_sky_face(out, face, name)
    ambient = mean(scene.background.get("ambientLight", (0, 0, 0)))
    for i, material in enumerate(scene.materials):
        out.write(f"TEXDEF M{i} {texture(material, ambient, bounces)}\n")
    for kind, material, m, content in scene.objects:
        look = texture(scene.materials[material], ambient, bounces)
        write_object(out, kind, m, content, f"M{material}", look)
    out.write("END_SCENE\n")


def write_camera(out, view, bounces):
    # The plane that a2's rays pass through is spanned by `right` and `up`; this is its normal. If the direction is
    # not perpendicular to `up`, the frustum is not symmetric about the axis.
    normal = cross(unit(view.up), view.right)
    distance, rise = dot(view.forward, normal), dot(view.forward, unit(view.up))
    half = math.sqrt(dot(view.up, view.up))
    # Tachyon counts pixels from 1 and shoots through left + i * (right - left)/W; x is mirrored: it is left-handed.
    step_x, step_y = 2 / (view.width - 1), 2 / (view.height - 1)
    left, right = (1 + step_x) / distance, -1 / distance
    bottom, top = (rise - half * (1 + step_y)) / distance, (rise + half) / distance
    out.write(
        f"CAMERA PROJECTION PERSPECTIVE ZOOM 1 ASPECTRATIO 1 ANTIALIASING 0 RAYDEPTH {bounces + 1}\n"
        f" CENTER {vector(view.center)} VIEWDIR {vector(normal)} UPDIR {vector(view.up)}\n"
        f" FRUSTUM {left:.9g} {right:.9g} {bottom:.9g} {top:.9g} END_CAMERA\n"
    )


def middle_of(objects):
    points = [point_by(m, content["center"]) for kind, _, m, content in objects if kind == "Sphere"]
    for kind, _, m, content in objects:
        if kind == "TriangleMesh":
            points += [point_by(m, v) for v in content.vertices]
    return tuple(sum(axis) / len(points) for axis in zip(*points)) if points else (0, 0, 0)


def write_light(out, kind, light, middle):
    if kind == "DirectionalLight":
        out.write(f"DIRECTIONAL_LIGHT DIRECTION {vector(unit(light['direction']))} COLOR {vector(light['color'])}\n")
    else:
        # Tachyon does not attenuate highlights, so the colour is that which arrives in the middle of the scene.
        to_middle = sub(middle, light["position"])
        square = dot(to_middle, to_middle)
        color = scale(light["color"], 1.0 / (light["falloff"] * square))
        fading = f"ATTENUATION CONSTANT 0 LINEAR 0 QUADRATIC {1.0 / square:.9g}"
        out.write(f"LIGHT CENTER {vector(light['position'])} RAD 0 {fading} COLOR {vector(color)}\n")


def write_sky_face(out, face, name):
    axis, u, v = FACE_AXES[face]
    place = scale(axis, HALF_WIDTH)
    # Tachyon keeps the rows of a PPM in their order, top row first.
    top_left = scale(add(sub(axis, u), v), HALF_WIDTH)
    stretch = SHARP / (2 * HALF_WIDTH)
    out.write(
        f"PLANE CENTER {vector(place)} NORMAL {vector(scale(axis, -1))}\n"
        f" TEXTURE AMBIENT 1 DIFFUSE 0 SPECULAR 0 OPACITY {CASTS_NO_SHADOW} COLOR 1 1 1 TEXFUNC 9 {name}.ppm\n"
        f"  CENTER {vector(top_left)} ROTATE 0 0 0 SCALE {1 / SHARP} {1 / SHARP} {1 / SHARP}\n"
        f"  UAXIS {vector(scale(u, stretch))} VAXIS {vector(scale(v, -stretch))}\n"
    )


def texture(material, ambient, bounces):
    specular = material.get("specularColor", (0, 0, 0))
    is_mirror = bounces > 0 and dot(specular, specular) > 0.1 * 0.1
    phong = f"PHONG PLASTIC {mean(specular):.9g} PHONG_SIZE {material.get('shininess', 0):.9g}" if any(specular) else ""
    return (
        f"AMBIENT {ambient:.9g} DIFFUSE 1 SPECULAR {mean(specular) if is_mirror else 0:.9g} OPACITY 1 {phong}"
        f" COLOR {vector(material.get('diffuseColor', (1, 1, 1)))} TEXFUNC 0"
    )


def write_object(out, kind, m, content, name, look):
    if kind == "Sphere" and m == IDENTITY:
        out.write(f"SPHERE CENTER {vector(content['center'])} RAD {content['radius']:.9g} {name}\n")
    elif kind == "Sphere":
        write_mesh(out, tessellated(content).world_from(m), look)
    elif kind == "Plane":
        n = content["normal"]
        foot = point_by(m, scale(n, content["offset"] / dot(n, n)))
        out.write(f"PLANE CENTER {vector(foot)} NORMAL {vector(normal_by(normal_matrix(m), n))} {name}\n")
    else:
        write_mesh(out, content.world_from(m), look)


def tessellated(sphere, rings=64, sectors=128):
    """Writes a sphere as triangles, because Tachyon cannot transform spheres."""
    normals = []
    for ring in range(rings + 1):
        polar = math.pi * ring / rings
        for sector in range(sectors):
            azimuth = 2 * math.pi * sector / sectors
            normals.append((math.sin(polar) * math.cos(azimuth), math.cos(polar), math.sin(polar) * math.sin(azimuth)))
    faces = []
    for ring in range(rings):
        for sector in range(sectors):
            a, b = ring * sectors + sector, ring * sectors + (sector + 1) % sectors
            faces += [(a, b, b + sectors)] if ring > 0 else []
            faces += [(a, b + sectors, a + sectors)] if ring < rings - 1 else []
    return Mesh([add(sphere["center"], scale(n, sphere["radius"])) for n in normals], normals, faces)


def write_mesh(out, mesh, look):
    out.write(f"VERTEXARRAY NUMVERTS {len(mesh.vertices)}\nCOORDS\n")
    out.writelines(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in mesh.vertices)
    out.write("NORMALS\n")
    out.writelines(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in mesh.normals)
    out.write(f"TEXTURE {look}\nTRIMESH {len(mesh.faces)}\n")
    out.writelines(f"{i} {j} {k}\n" for i, j, k in mesh.faces)
    out.write("END_VERTEXARRAY\n")

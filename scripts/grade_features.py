"""Finds out which feature a program lacks: renders the scene without each feature, and looks which picture is the program's."""

import dataclasses
import itertools
import re
import threading
from pathlib import Path

import comparing

# With this shininess no highlight is larger than a point. (A specular colour of 0 would take the mirrors away, too.)
NO_HIGHLIGHT = "shininess 1000000000"
FILE = r'("[^"]*"|\S+)'


def spaced(text):
    """Returns a scene with its braces set off by spaces, so that words can be replaced."""
    return re.sub(r"([{}])", r" \1 ", text)


def without_flag(name):
    """Returns a function that takes a flag away, with its values."""
    return lambda flags: re.sub(rf"{name}( [^-]\S*)*", "", " ".join(flags)).split()


@dataclasses.dataclass
class Feature:
    """Something that a program may lack."""

    name: str
    # From the text of a scene (with spaces around braces) and its flags: does it show the feature?
    is_shown: object
    # Change the flags and the text of a scene so that it does not.
    change_flags: object = list
    change_text: object = str
    # Whether meshes are replaced by copies whose faces share no corners.
    splits_meshes: bool = False


FEATURES = [
    Feature("-shadows", lambda text, flags: "-shadows" in flags, without_flag("-shadows")),
    Feature("mirrors (-bounces 0)", lambda text, flags: "-bounces" in flags, without_flag("-bounces")),
    Feature(
        "highlights",
        lambda text, flags: "specularColor" in text,
        change_text=lambda text: re.sub(
            r"\b((?:Phong)?Material\s*{)", rf"\1 {NO_HIGHLIGHT}", re.sub(r"\bshininess\s+\S+", "", text)
        ),
    ),
    Feature(
        "an offset of shadow and mirror rays (-epsilon 0)",
        lambda text, flags: "-shadows" in flags or "-bounces" in flags,
        lambda flags: [*flags, "-epsilon", "0"],
    ),
    Feature("smooth normals", lambda text, flags: "obj_file" in text, splits_meshes=True),
    Feature(
        "the cube map",
        lambda text, flags: "cubeMap" in text,
        change_text=lambda text: re.sub(rf"\bcubeMap\s+{FILE}", "", text),
    ),
    Feature(
        "ambient light",
        lambda text, flags: "ambientLight" in text,
        change_text=lambda text: re.sub(r"\b(ambientLight)(\s+\S+){3}", r"\1 0 0 0", text),
    ),
]


def split_corners(text):
    """Returns an OBJ file whose faces share no vertices, so that each is flat."""
    vertices, lines = [], []
    for line in text.splitlines():
        word, *values = line.split() or [""]
        if word == "v":
            vertices.append(" ".join(values[:3]))
        elif word == "f":
            corners = [int(value.partition("/")[0]) for value in values]
            # Negative ones count from the end of the vertices so far.
            chosen = [vertices[corner - 1 if corner > 0 else corner] for corner in corners]
            lines += [f"v {vertex}" for vertex in chosen]
            lines.append("f " + " ".join(str(number - len(chosen)) for number in range(len(chosen))))
    return "\n".join(lines) + "\n"


class Variants:
    """Pictures of the scenes without some features, rendered by a2 when they are first asked for."""

    def __init__(self, a2, data, size, folder):
        self.a2, self.data, self.size, self.folder = a2, Path(data), size, Path(folder)
        self.rendered = {}
        self.lock = threading.Lock()

    def of(self, scene):
        """Yields sets of features of a scene and the folder with the pictures without them: none, one, two."""
        text = spaced((self.data / f"{scene.name}.txt").read_text())
        shown = [feature for feature in FEATURES if feature.is_shown(text, scene.flags)]
        for count in range(3):
            for chosen in itertools.combinations(shown, count):
                yield [feature.name for feature in chosen], self.folder_of(scene, text, chosen)

    def folder_of(self, scene, text, features):
        key = (scene.number, *(feature.name for feature in features))
        with self.lock:
            if key not in self.rendered:
                self.rendered[key] = self.render(scene, text, features)
            return self.rendered[key]

    def render(self, scene, text, features):
        folder = self.folder / f"variant{len(self.rendered)}"
        folder.mkdir()
        flags = scene.flags
        for feature in features:
            flags, text = feature.change_flags(flags), feature.change_text(text)
        split = any(feature.splits_meshes for feature in features)
        text = re.sub(rf"\bcubeMap\s+{FILE}", lambda found: f'cubeMap "{self.path(found[1])}"', text)
        text = re.sub(rf"\bobj_file\s+{FILE}", lambda found: f'obj_file "{self.mesh(found[1], split, folder)}"', text)
        (folder / f"{scene.name}.txt").write_text(text)
        changed = dataclasses.replace(scene, flags=flags)
        comparing.render(changed.command(self.a2, folder, self.size, folder))
        return folder

    def path(self, name):
        """Returns the whole path of a file that a scene names."""
        return (self.data / name.strip('"')).resolve()

    def mesh(self, name, split, folder):
        path = self.path(name)
        if not split:
            return path
        copy = folder / path.name
        copy.write_text(split_corners(path.read_text()))
        return copy

"""Pictures through OpenGL without a display (moderngl on EGL; in software where there is no GPU).

All light comes from a few dozen parallel lights, each with a shadow map of its own in one atlas: the sum is a soft
shadow and ambient occlusion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .camera import Camera, Lights
from .scene import Scene

_MAP = 256  # pixels of one shadow map
_SAMPLES = 2  # supersampling per axis

_VERTEX = """
#version 330
uniform mat4 view;
invariant gl_Position;
in vec3 position; in vec3 normal; in vec4 colour; in vec2 surface;
out vec3 at; out vec3 n; out vec4 tint; out vec2 finish;
void main() { at = position; n = normal; tint = colour; finish = surface; gl_Position = view * vec4(position, 1.0); }
"""

_FRAGMENT = """
#version 330
const int COUNT = @COUNT@;
const int COLUMNS = @COLUMNS@;
uniform sampler2DShadow shadows;
uniform mat4 to_light[COUNT];
uniform vec3 direction[COUNT];
uniform vec3 power[COUNT];
uniform vec3 eye; uniform vec3 backdrop;
uniform float offset; uniform float sun_count; uniform float ground; uniform float pixels;
in vec3 at; in vec3 n; in vec4 tint; in vec2 finish;
out vec4 result;

float seen(int k, vec3 p, float turn) {
    vec3 q = (to_light[k] * vec4(p, 1.0)).xyz * 0.5 + 0.5;
    vec2 cell = vec2(k % COLUMNS, k / COLUMNS);
    if (any(lessThan(q.xy, vec2(0.004))) || any(greaterThan(q.xy, vec2(0.996)))) return 1.0;
    // one tap beside the point, turned from pixel to pixel: supersampling makes a soft edge of it
    float r = 0.0085 * sqrt(fract(turn * 1.618));
    vec2 tap = clamp(q.xy + r * vec2(cos(turn), sin(turn)), vec2(0.002), vec2(0.998));
    return texture(shadows, vec3((tap + cell) / COLUMNS, q.z - 0.004));
}

float surroundings(vec3 r, float rough) {      // what a mirror sees, as deferred.py has it
    float blur = 0.03 + 0.6 * rough;
    vec2 sun = normalize(direction[0].xy);
    float aside = abs(dot(r.xy, vec2(-sun.y, sun.x)));
    float side = smoothstep(0.80 - blur, 0.80 + blur, aside) * (1.0 - smoothstep(0.55 - blur, 0.55 + blur, abs(r.z)));
    float lamp = 0.86 * smoothstep(0.42 - blur, 0.42 + blur, r.z) + 0.60 * side;
    float table = 0.30 * smoothstep(0.22 - blur, 0.22 + blur, -r.z);
    return 0.22 + lamp + table + 0.25 * smoothstep(0.55, 0.95, dot(r, direction[0]));
}

void main() {
    vec3 v = normalize(eye - at);
    vec3 m = normalize(n);
    if (ground < 0.5 && dot(m, v) < 0.0) m = -m;
    vec3 p = at + m * offset;
    vec3 light = vec3(0.0), shine = vec3(0.0);
    float turn = 6.2832 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    float gloss = finish.y, sharp = exp2(2.0 + 7.0 * gloss);
    // the four samples of a pixel share the lights out: their mean has seen every one
    ivec2 sample_at = ivec2(gl_FragCoord.xy) % 2;
    vec3 open = vec3(0.0);
    for (int k = sample_at.y * 2 + sample_at.x; k < COUNT; k += 4) {
        float facing = dot(m, direction[k]);
        if (facing <= 0.0) continue;
        float visible = seen(k, p, turn + 2.4 * float(k));
        light += 4.0 * visible * facing * power[k];
        open += 4.0 * facing * power[k];
        if (float(k) < sun_count)
            shine += 4.0 * visible * power[k] * pow(max(dot(m, normalize(direction[k] + v)), 0.0), sharp);
    }
    if (ground > 0.5) {                // bare ground is the backdrop itself; shadows fade out towards the border
        vec2 border = min(gl_FragCoord.xy, vec2(pixels) - gl_FragCoord.xy) / pixels;
        float kept = smoothstep(0.0, 0.12, min(border.x, border.y));
        result = vec4(backdrop * mix(vec3(1.0), pow(light / open, vec3(0.85)), kept), 1.0);
        return;
    }
    light += vec3(0.13) + 0.10 * backdrop * (0.5 - 0.5 * m.z);         // what comes back from the ground and around
    float edge = pow(1.0 - max(dot(m, v), 0.0), 5.0);
    float mirrored = surroundings(reflect(-v, m), 1.0 - gloss) * clamp(length(light), 0.25, 1.1);
    vec3 base = mix(vec3(0.04), tint.rgb, finish.x);
    vec3 fresnel = base + (1.0 - base) * edge * gloss;
    vec3 body = tint.rgb * light * (1.0 - finish.x);
    vec3 c = body + fresnel * mirrored * mix(0.5 * gloss, 1.0, finish.x) + shine * base * (1.0 + 7.0 * gloss) * 1.6;
    float alpha = tint.a;
    if (alpha < 0.999) alpha = clamp(alpha + edge * 0.6 + length(shine) * gloss, 0.0, 1.0);
    result = vec4(c, alpha);
}
"""

_SHADOW = """
#version 330
uniform mat4 view;
invariant gl_Position;
in vec3 position;
void main() { gl_Position = view * vec4(position, 1.0); }
"""


class Renderer:
    """Draws scenes in tiles of ``size`` pixels. Raises ImportError or an error of the library where GL is missing."""

    name = "moderngl"
    light_counts = (16, 48)  # sun, sky

    def __init__(self, size: int, backdrop: np.ndarray):
        import moderngl

        self.gl = moderngl
        headless: dict[str, Any] = {"backend": "egl"}
        self.context: Any = moderngl.create_context(standalone=True, **headless)
        self.size, self.backdrop = size, backdrop
        count = sum(self.light_counts)
        self.columns = int(np.ceil(np.sqrt(count)))
        fragment = _FRAGMENT.replace("@COUNT@", str(count)).replace("@COLUMNS@", str(self.columns))
        self.program: Any = self.context.program(_VERTEX, fragment)
        self.shadow_program: Any = self.context.program(_SHADOW, "#version 330\nvoid main() {}\n")
        edge = _MAP * self.columns
        self.atlas = self.context.depth_texture((edge, edge))
        self.atlas.compare_func = "<="
        self.atlas.repeat_x = self.atlas.repeat_y = False
        self.shadow_target = self.context.framebuffer(depth_attachment=self.atlas)
        big = (size * _SAMPLES, size * _SAMPLES)
        self.target = self.context.framebuffer(
            self.context.renderbuffer(big, 4, dtype="f2"), self.context.depth_renderbuffer(big)
        )

    def render(self, scene: Scene, camera: Camera, lights: Lights, floor: float) -> np.ndarray:
        """Linear light (size, size, 3) of a scene that stands on the plane z = ``floor``."""
        opaque, clear = scene.split()
        surface = np.stack([scene.metalness, scene.gloss], axis=-1)
        vertices = np.concatenate([scene.vertices, scene.normals, scene.colour, surface], axis=1).astype("f4")
        low, high = scene.vertices.min(axis=0), scene.vertices.max(axis=0)
        low[2] = min(low[2], floor)
        matrices = light_matrices(lights, low, high)
        vertex_buffer = self.context.buffer(vertices.tobytes())
        made = [vertex_buffer]
        try:
            self._shadows(vertex_buffer, scene.faces[opaque], matrices, made)
            return self._picture(vertex_buffer, scene, (opaque, clear), camera, lights, floor, matrices, made)
        finally:
            for thing in reversed(made):
                thing.release()

    def _shadows(self, vertices: Any, faces: np.ndarray, matrices: np.ndarray, made: list[Any]) -> None:
        context = self.context
        self.shadow_target.use()
        context.enable_only(self.gl.DEPTH_TEST)
        self.shadow_target.viewport = (0, 0, *self.atlas.size)
        self.shadow_target.clear(depth=1.0)
        if not len(faces):
            return
        indices = context.buffer(faces.astype("u4").tobytes())
        array = context.vertex_array(self.shadow_program, [(vertices, "3f 36x", "position")], indices)
        made += [indices, array]
        for k, matrix in enumerate(matrices):
            self.shadow_target.viewport = (k % self.columns * _MAP, k // self.columns * _MAP, _MAP, _MAP)
            self.shadow_program["view"].write(matrix.T.astype("f4").tobytes())
            array.render()

    def _picture(
        self,
        vertices: Any,
        scene: Scene,
        faces: tuple[np.ndarray, np.ndarray],
        camera: Camera,
        lights: Lights,
        floor: float,
        matrices: np.ndarray,
        made: list[Any],
    ) -> np.ndarray:
        context, program = self.context, self.program
        extent = float(np.abs(scene.vertices.max(axis=0) - scene.vertices.min(axis=0)).max())
        self.atlas.use(0)
        values = {
            "view": camera.matrix().T,
            "to_light": matrices.transpose(0, 2, 1),
            "direction": lights.direction,
            "power": lights.power(),
            "eye": camera.eye,
            "backdrop": self.backdrop,
            "offset": np.array([extent * 0.006]),
            "sun_count": np.array([float(lights.sun.sum())]),
            "pixels": np.array([self.size * float(_SAMPLES)]),
        }
        for name, value in values.items():
            program[name].write(np.ascontiguousarray(value, dtype="f4").tobytes())
        program["shadows"].value = 0
        self.target.use()
        self.target.viewport = (0, 0, self.size * _SAMPLES, self.size * _SAMPLES)
        red, green, blue = self.backdrop.tolist()
        self.target.clear(red, green, blue, 1.0, depth=1.0)
        context.enable_only(self.gl.DEPTH_TEST)
        layout = [(vertices, "3f 3f 4f 2f", "position", "normal", "colour", "surface")]
        opaque, clear = faces
        program["ground"].value = 0.0
        if len(opaque):
            indices = context.buffer(scene.faces[opaque].astype("u4").tobytes())
            depth_only = context.vertex_array(self.shadow_program, [(vertices, "3f 36x", "position")], indices)
            array = context.vertex_array(program, layout, indices)
            made += [indices, depth_only, array]
            self.shadow_program["view"].write(np.ascontiguousarray(camera.matrix().T, dtype="f4").tobytes())
            depth_only.render()  # depth first: the costly shading then runs once per sample
            context.depth_func = "<="
            array.render()
        self._ground(scene, floor, made)
        program["ground"].value = 0.0
        if len(clear):
            context.enable_only(self.gl.DEPTH_TEST | self.gl.BLEND | self.gl.CULL_FACE)
            context.blend_func = self.gl.SRC_ALPHA, self.gl.ONE_MINUS_SRC_ALPHA
            depth = camera.local(scene.vertices[scene.faces[clear]].mean(axis=1))[2]
            far_first = clear[np.argsort(depth, kind="stable")]
            indices = context.buffer(scene.faces[far_first].astype("u4").tobytes())
            array = context.vertex_array(program, layout, indices)
            made += [indices, array]
            self.target.depth_mask = False
            array.render()
            self.target.depth_mask = True
        raw = np.frombuffer(self.target.read(components=3, dtype="f2"), dtype=np.float16)
        image = raw.reshape(self.size, _SAMPLES, self.size, _SAMPLES, 3).astype(np.float32)
        return np.clip(image.mean(axis=(1, 3))[::-1], 0.0, 1.0)

    def _ground(self, scene: Scene, floor: float, made: list[Any]) -> None:
        low, high = scene.vertices.min(axis=0), scene.vertices.max(axis=0)
        reach = float((high - low).max()) * 40
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * reach + (low[:2] + high[:2]) / 2
        vertices = np.zeros((4, 12), dtype="f4")
        vertices[:, :2], vertices[:, 2], vertices[:, 5] = corners, floor, 1.0
        buffer = self.context.buffer(vertices.tobytes())
        indices = self.context.buffer(np.array([0, 1, 2, 0, 2, 3], dtype="u4").tobytes())
        layout = [(buffer, "3f 3f 4f 2f", "position", "normal", "colour", "surface")]
        array = self.context.vertex_array(self.program, layout, indices)
        made += [buffer, indices, array]
        self.program["ground"].value = 1.0
        array.render()


def light_matrices(lights: Lights, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """World to clip coordinates (K, 4, 4) of parallel lights that cover the box ``low`` .. ``high``."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    matrices = np.zeros((len(lights.direction), 4, 4))
    for k, direction in enumerate(lights.direction):
        side = np.cross([0.0, 0.0, 1.0], direction)
        side = side / np.sqrt((side * side).sum())
        axes = np.stack([side, np.cross(direction, side), -direction])
        local = corners @ axes.T
        middle = (local.min(axis=0) + local.max(axis=0)) / 2
        half = (local.max(axis=0) - local.min(axis=0)) / 2 * 1.02 + 1e-6
        matrices[k, :3, :3] = axes / half[:, None]
        matrices[k, :3, 3] = -middle / half
        matrices[k, 3, 3] = 1.0
    return matrices

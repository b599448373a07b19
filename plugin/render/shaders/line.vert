#version 330 core
// One instance a line: its ends become the corners of a strip so many pixels wide.
layout(location = 0) in vec3 line_from;  // about the eye [m]
layout(location = 1) in vec3 line_to;
layout(location = 2) in vec3 line_color;
uniform mat4 clip;
uniform vec2 picture_size;  // pixels
uniform float width;        // pixels
out vec3 albedo;
void main() {
    const float kNear = 1e-4;  // of the clip space's w
    vec4 a = clip * vec4(line_from, 1.0), b = clip * vec4(line_to, 1.0);
    albedo = line_color;
    // An end behind the eye is brought in front of it.
    if (a.w < kNear && b.w < kNear) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    if (a.w < kNear) a = mix(a, b, (kNear - a.w) / (b.w - a.w));
    if (b.w < kNear) b = mix(b, a, (kNear - b.w) / (a.w - b.w));
    vec2 along = (b.xy / b.w - a.xy / a.w) * picture_size;
    along = dot(along, along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x) * width / picture_size;
    vec4 end = (gl_VertexID & 1) != 0 ? b : a;
    end.xy += ((gl_VertexID & 2) != 0 ? across : -across) * end.w;
    end.z -= 2e-5 * end.w;  // lines on a surface are in front of it
    gl_Position = end;
}

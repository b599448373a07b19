#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 color;
layout(location = 5) in float wetness;
uniform mat4 model;  // mesh -> world axes about the eye
uniform mat4 clip;   // those -> clip space
uniform vec4 cut;    // what is above 0 is left out; 0 of an item that is not cut: some drivers clip unasked
out vec3 world;      // about the eye [m]
out vec3 world_normal;
out vec3 albedo;
out float wet;       // saturation, 0..1
#ifdef MIXED
layout(location = 3) in vec4 weights_low;  // of the first four materials
layout(location = 4) in vec4 weights_high;
out vec4 low, high;
#endif
#ifdef TEXTURED
layout(location = 6) in vec2 skin_place;  // from the lower left corner
out vec2 texel;
#endif
void main() {
    vec4 p = model * vec4(position, 1.0);
    world = p.xyz;
    world_normal = mat3(model) * normal;
    albedo = color;
    wet = wetness;
#ifdef MIXED
    low = weights_low;
    high = weights_high;
#endif
#ifdef TEXTURED
    texel = vec2(skin_place.x, 1.0 - skin_place.y);
#endif
    gl_Position = clip * p;
    gl_ClipDistance[0] = -dot(cut, p);
}

#version 330 core
// For programs that learn to see: depth along the line of sight, normal, and which item it is.
in vec3 world;         // about the eye
in vec3 world_normal;
uniform vec3 sight;    // unit, where the camera looks
uniform uint item_label;
layout(location = 0) out vec4 normal_depth;
layout(location = 1) out uint label;
void main() {
    normal_depth = vec4(normalize(world_normal), dot(world, sight));
    label = item_label;
}

#version 330 core
// What is seen in a pixel; light.frag lights it. Triangles of a fine mesh are a few pixels wide, and a software GL shades blocks of
// pixels for each: so little is done here.
in vec3 world_normal;
in vec3 albedo;
uniform float material;  // row of the table, 0..1
layout(location = 0) out vec4 albedo_material;  // square roots: dark colours need the finer steps
layout(location = 1) out vec2 octahedral;       // the normal, 0..1
void main() {
    vec3 n = world_normal / (abs(world_normal.x) + abs(world_normal.y) + abs(world_normal.z));
    vec2 folded = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
    octahedral = 0.5 + 0.5 * (n.z < 0.0 ? folded : n.xy);
    albedo_material = vec4(sqrt(albedo), material);
}

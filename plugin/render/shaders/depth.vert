#version 330 core
// Depth only: the sun's shadow map, and what the ambient occlusion reads.
layout(location = 0) in vec3 position;
uniform mat4 model;  // mesh -> world axes about the eye
uniform mat4 clip;   // those -> clip space
void main() { gl_Position = clip * (model * vec4(position, 1.0)); }

#version 330 core
// The lit picture in its last size: the mean of what is lit in a pixel. Edges of a picture lit once a pixel are edges.frag's.
in vec2 screen;
out vec4 color;
uniform sampler2D lit;
void main() { color = vec4(texture(lit, 0.5 + 0.5 * screen).rgb, 1.0); }

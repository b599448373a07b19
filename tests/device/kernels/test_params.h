// The uniform block of the test kernels. One member a line.
int list_offset;  // where a dispatch's list starts in entries
int stride;       // words of one plane of outputs
int unused;       // an odd number of words: std140 rounds the block up

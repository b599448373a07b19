// The buffers of the test kernels in binding order.
BUFFER(inputs)
BUFFER(outputs)
BUFFER(entries)
BUFFER(neighbours)
BUFFER(tickets)
BUFFER(counts)
#ifndef LONG_BUFFER
#define LONG_BUFFER(name) BUFFER(name)
#endif
LONG_BUFFER(marks)
#undef LONG_BUFFER

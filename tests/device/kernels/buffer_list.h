// The buffers of the test kernels in binding order.
BUFFER(inputs)
BUFFER(outputs)
BUFFER(entries)
BUFFER(neighbours)
BUFFER(tickets)
BUFFER(counts)

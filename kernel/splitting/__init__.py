"""Splitting methods, cheapest at moderate accuracy.

For light damping an explicit fourth-order splitting (kernel.splitting.explicit), for strong damping a leapfrog with
Crank-Nicolson dampers (kernel.splitting.implicit); kernel.method says where. The linear chain is the one with a linear
spring. Both are packed over the sites of one chain, so the bits of a task depend on nothing but the task.
"""

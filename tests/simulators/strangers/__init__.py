"""How people who know nothing of this project would drive its files: each module loads a file as its simulator's manual says,
puts a bounded position controller on one joint after the other and says where it came to. Nothing here may import
``artipg_dsl``, or the adapters beside it: what a driver knows it has read from the file with the simulator's own calls."""

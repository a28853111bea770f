"""Studies: run many labelled scenarios, measure them into one pandas frame, analyse the frame."""

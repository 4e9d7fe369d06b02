//! Central air loops: supply temperature, outdoor air, dampers, reheat.

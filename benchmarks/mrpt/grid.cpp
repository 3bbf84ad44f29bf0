// Draws pings into MRPT's occupancy grid and prints the seconds of processor time that took: grid PINGS RESOLUTION
// PINGS has the rows "x y bearing range reach aperture".
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/poses/CPose3D.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <vector>

struct Ping {
  double x, y, bearing, range, reach, aperture;
};

int main(int, char** arguments) {
  std::vector<Ping> pings;
  std::ifstream file(arguments[1]);
  for (Ping ping; file >> ping.x >> ping.y >> ping.bearing >> ping.range >> ping.reach >> ping.aperture;) {
    pings.push_back(ping);
  }
  mrpt::maps::COccupancyGridMap2D map(-5, 9, -5, 8, std::atof(arguments[2]));
  map.insertionOptions.maxDistanceInsertion = 4;
  const std::clock_t start = std::clock();
  for (const Ping& ping : pings) {
    mrpt::obs::CObservationRange observation;
    observation.minSensorDistance = 0.02f;
    observation.maxSensorDistance = ping.reach;
    observation.sensorConeApperture = ping.aperture;
    observation.sensedData.resize(1);
    observation.sensedData[0].sensedDistance = ping.range;
    const mrpt::poses::CPose3D pose(ping.x, ping.y, 0, ping.bearing, 0, 0);
    map.insertObservation(observation, pose);
  }
  std::cout << double(std::clock() - start) / CLOCKS_PER_SEC << "\n";
}

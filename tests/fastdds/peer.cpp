// A peer of ROS 2 by Fast DDS: publishes readings, and receives the map as CDR, as rmw_fastrtps would.
// Usage: peer DOMAIN SECONDS RANGE.cdr; prints how many messages came, and writes the last map to map.cdr.
#include <chrono>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;
using Bytes = std::vector<char>;

// Carries CDR as it is; like the types of rmw_fastrtps, it is known by its name alone.
class Raw : public TopicDataType {
 public:
  explicit Raw(const char* name) {
    setName(name);
    m_typeSize = 4 << 20;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = bytes.size();
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  DomainParticipantQos network;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back("127.0.0.1");
  network.transport().use_builtin_transports = false;
  network.transport().user_transports.push_back(udp);
  eprosima::fastrtps::rtps::Locator_t local;
  local.kind = LOCATOR_KIND_UDPv4;
  local.port = 0;
  eprosima::fastrtps::rtps::IPLocator::setIPv4(local, 127, 0, 0, 1);
  network.wire_protocol().builtin.initialPeersList.push_back(local);
  auto* participant = DomainParticipantFactory::get_instance()->create_participant(std::stoi(argv[1]), network);
  TypeSupport range(new Raw("sensor_msgs::msg::dds_::Range_")), map(new Raw("nav_msgs::msg::dds_::OccupancyGrid_"));
  range.register_type(participant);
  map.register_type(participant);
  // What rmw_fastrtps offers by default.
  DataWriterQos offered = DATAWRITER_QOS_DEFAULT;
  offered.reliability().kind = RELIABLE_RELIABILITY_QOS;
  offered.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  auto* publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
  auto* writer = publisher->create_datawriter(
      participant->create_topic("rt/sonar", range.get_type_name(), TOPIC_QOS_DEFAULT), offered);
  // What Nav2 asks for.
  DataReaderQos asked = DATAREADER_QOS_DEFAULT;
  asked.reliability().kind = RELIABLE_RELIABILITY_QOS;
  asked.durability().kind = TRANSIENT_LOCAL_DURABILITY_QOS;
  asked.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  auto* subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  auto* reader =
      subscriber->create_datareader(participant->create_topic("rt/map", map.get_type_name(), TOPIC_QOS_DEFAULT), asked);
  std::ifstream file(argv[3], std::ios::binary);
  Bytes message((std::istreambuf_iterator<char>(file)), {}), received;
  int count = 0;
  SampleInfo info;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(std::stoi(argv[2]));
  while (std::chrono::steady_clock::now() < end && !count) {
    writer->write(&message);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    while (reader->take_next_sample(&received, &info) == ReturnCode_t::RETCODE_OK) count += info.valid_data;
  }
  std::ofstream("map.cdr", std::ios::binary).write(received.data(), received.size());
  std::cout << "maps " << count << std::endl;
  return count == 0;
}

#ifndef ROS_CALLBACK_H_
#define ROS_CALLBACK_H_

namespace ros {

// A member function with its object, or (Object = void) a free function.
template <class Object, class... Arguments>
class Callback {
 public:
  typedef void (Object::*Function)(Arguments...);

  constexpr Callback(Function function, Object* object) : function_(function), object_(object) {}
  void operator()(Arguments... arguments) const { (object_->*function_)(arguments...); }

 private:
  Function function_;
  Object* object_;
};

template <class... Arguments>
class Callback<void, Arguments...> {
 public:
  typedef void (*Function)(Arguments...);

  constexpr explicit Callback(Function function) : function_(function) {}
  void operator()(Arguments... arguments) const { function_(arguments...); }

 private:
  Function function_;
};

}  // namespace ros

#endif

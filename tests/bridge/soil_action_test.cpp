int placeholder_action;

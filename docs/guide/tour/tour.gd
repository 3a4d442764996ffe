@tool
extends EditorPlugin
## Takes the steps of the guide's 'Install' page in the editor, and a picture of each: script/first-steps.

const SCENE := "res://main.tscn"
const SCAN := "res://head"
## Of a picture that nobody calls noisy.
const SAMPLES := 24.0
const LONGEST_MS := 400_000


func _enter_tree() -> void:
	# Also loaded where the project is only imported.
	if DisplayServer.get_name() != "headless":
		_tour.call_deferred()


func _tour() -> void:
	var folders := OS.get_cmdline_user_args()
	await _wait(5.0)
	await _take(folders[0], "godot-plugin", _show_plugins())
	EditorInterface.get_file_system_dock().navigate_to_path(_scan())
	await _take(folders[0], "godot-scan", null)
	EditorInterface.open_scene_from_path(SCENE)
	await _wait(3.0)
	var root := EditorInterface.get_edited_scene_root()
	var node: Node3D = ClassDB.instantiate(&"LumivoxVolume3D")
	node.name = "Head"
	root.add_child(node)
	node.owner = root
	node.position = Vector3(0.0, 0.135, 0.0)
	EditorInterface.edit_node(node)
	await _take(folders[0], "godot-node", null)
	node.set(&"volume", load(_scan()))
	EditorInterface.edit_node(node)
	await _wait(2.0)
	_focus()
	await _come_closer()
	await _wait(3.0)
	var begin := Time.get_ticks_msec()
	while _samples() < SAMPLES and Time.get_ticks_msec() - begin < LONGEST_MS:
		await get_tree().process_frame
	await _take(folders[0], "godot-volume", null)
	EditorInterface.save_scene()
	await _wait(1.0)
	get_tree().quit()


## The first file of the scan, by which the editor knows it.
func _scan() -> String:
	for file in DirAccess.get_files_at(SCAN):
		if ResourceLoader.exists(SCAN.path_join(file)):
			return SCAN.path_join(file)
	push_error("the scan was not imported")
	return ""


func _show_plugins() -> Window:
	var base := EditorInterface.get_base_control()
	var window: Window = base.find_children("*", "ProjectSettingsEditor", true, false)[0]
	window.popup_centered(Vector2i(900, 420))
	for tabs: TabContainer in window.find_children("*", "TabContainer", true, false):
		for tab in tabs.get_tab_count():
			if tabs.get_tab_title(tab) == "Plugins":
				tabs.current_tab = tab
	return window


## As the key F does in the 3D view.
func _focus() -> void:
	var view := EditorInterface.get_base_control().find_children("*", "Node3DEditorViewport", true, false)[0]
	for menu: MenuButton in view.find_children("*", "MenuButton", true, false):
		var popup := menu.get_popup()
		for item in popup.item_count:
			if popup.get_item_text(item) == "Focus Selection":
				popup.id_pressed.emit(popup.get_item_id(item))


## The mouse's wheel over the 3D view: scans are of true size, and the view begins metres away.
func _come_closer() -> void:
	var view: Control = EditorInterface.get_base_control().find_children("*", "Node3DEditorViewport", true, false)[0]
	for turn in 22:
		for pressed in [true, false]:
			var wheel := InputEventMouseButton.new()
			wheel.button_index = MOUSE_BUTTON_WHEEL_UP
			wheel.pressed = pressed
			wheel.factor = 1.0
			wheel.position = view.get_global_rect().get_center()
			wheel.global_position = wheel.position
			get_tree().root.push_input(wheel)
		await get_tree().process_frame


func _samples() -> float:
	var lumivox := Engine.get_singleton(&"Lumivox")
	var status: Dictionary = lumivox.call(&"get_status", EditorInterface.get_editor_viewport_3d(0))
	return status.get("pixel_samples", 0.0)


func _wait(seconds: float) -> void:
	await get_tree().create_timer(seconds).timeout


func _take(folder: String, name: String, window: Window) -> void:
	await _wait(2.0)
	var picture := get_tree().root.get_texture().get_image()
	picture.save_png(folder.path_join(name + ".png"))
	print("PICTURE ", name)
	if window != null:
		window.hide()

extends "demo_scene.gd"
## The transfer-function editor on its own, over the whole width, in a running game.

const PanelTheme := preload("res://addons/lumivox/ui/panel_theme.gd")

## The volume that is edited.
@export var head: LumivoxVolume3D
## The editor.
@export var editor: LumivoxTransferFunctionEditor
## What the editor lies on.
@export var ground: Control

var _undo := UndoRedo.new()


func _ready() -> void:
	super()
	ground.theme = PanelTheme.create()
	editor.apply_presets = false
	editor.preset_chosen.connect(_on_preset_chosen)
	editor.edit_finished.connect(_on_edit_finished)


func _exit_tree() -> void:
	_undo.free()


func _unhandled_key_input(event: InputEvent) -> void:
	if event.is_action_pressed(&"ui_redo", false, true):
		_undo.redo()
	elif event.is_action_pressed(&"ui_undo", false, true):
		_undo.undo()


func _on_grown(volume: LumivoxVolume) -> void:
	super(volume)
	editor.volume = volume
	editor.transfer_function = head.transfer_function


func _on_preset_chosen(preset: String) -> void:
	head.apply_preset(preset)
	editor.transfer_function = head.transfer_function
	_undo.clear_history()


func _on_edit_finished(before: Dictionary, after: Dictionary) -> void:
	_undo.create_action("Edit", UndoRedo.MERGE_ENDS if editor.merges else UndoRedo.MERGE_DISABLE)
	_undo.add_do_method(editor.restore.bind(editor.transfer_function, after))
	_undo.add_undo_method(editor.restore.bind(editor.transfer_function, before))
	_undo.commit_action(false)
